#include "apps/info/info_vertical.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <string>
#include <utility>

namespace foreland::apps {

namespace {

using nlohmann::ordered_json;

const char* kindOf(proto::ZeroSurface zero_surface) {
  switch (zero_surface) {
    case proto::ZeroSurface::kEllipsoid:
      return "ellipsoid";
    case proto::ZeroSurface::kGeoid:
      return "sea level";
    default:
      return "unstated";
  }
}

// Over the scene, at the grid's values and the scene's corners.
std::pair<double, double> rangeOf(const terrain::Scene& scene) {
  const proto::UndulationGrid& grid = scene.vertical().undulations;
  if (scene.grid().isCube()) {  // a grid by degrees, all of which lies over the scene
    const auto [low, high] = std::ranges::minmax(grid.metres);
    return {low, high};
  }
  const glm::dvec2 last(scene.grid().shape().samples_x - 1.0, scene.grid().shape().samples_y - 1.0);
  std::pair<double, double> range{grid.at({0, 0}), grid.at({0, 0})};
  for (uint32_t row = 0; row < grid.rows; ++row)
    for (uint32_t column = 0; column < grid.columns; ++column) {
      const glm::dvec2 p = grid.first + glm::dvec2(column, row) * grid.step;
      const double n = grid.at({std::clamp(p.x, 0.0, last.x), std::clamp(p.y, 0.0, last.y)});
      range = {std::min(range.first, n), std::max(range.second, n)};
    }
  return range;
}

void printInput(const terrain::SceneInput& input) {
  const proto::LatticeWindow& w = input.window;
  std::printf("input      %s: %u x %u samples from (%u, %u), heights above %s", input.name.c_str(), w.width, w.height,
              w.x, w.y, input.vertical.empty() ? "what is unstated" : input.vertical.c_str());
  if (std::isnan(input.residual_m))
    std::printf(", residual not known\n");
  else
    std::printf(", residual at most %g m\n", input.residual_m);
  if (input.feather_m > 0)
    std::printf("           its edges are mixed with what is below over %g m, where that is more\n", input.feather_m);
}

}  // namespace

void printVertical(const terrain::Scene& scene) {
  const proto::VerticalDatum& datum = scene.vertical();
  if (datum.name.empty())
    std::printf("datum      unstated: nothing says what heights are above (--vertical)\n");
  else
    std::printf("datum      heights are above %s (%s)\n", datum.name.c_str(), kindOf(datum.zero_surface));
  if (!datum.geoid.empty()) {
    const auto [lowest_m, highest_m] = rangeOf(scene);
    std::printf("geoid      %s, %.3f to %.3f m above the ellipsoid here; stored as %u x %u values, within %.4f m\n",
                datum.geoid.c_str(), lowest_m, highest_m, datum.undulations.columns, datum.undulations.rows,
                datum.undulations.max_error_m);
  }
  if (scene.hasSea())
    std::printf("sea        drawn at height 0 above %s\n", datum.geoid.empty() ? "the ellipsoid" : datum.geoid.c_str());
  for (const terrain::SceneInput& input : scene.inputs()) printInput(input);
}

ordered_json describeVertical(const terrain::Scene& scene) {
  const proto::VerticalDatum& datum = scene.vertical();
  ordered_json about{{"zero_surface", kindOf(datum.zero_surface)}};
  if (!datum.name.empty()) about["name"] = datum.name;
  if (!datum.geoid.empty()) {
    const auto [lowest_m, highest_m] = rangeOf(scene);
    about["geoid"] = {{"name", datum.geoid},
                      {"undulation_m", {lowest_m, highest_m}},
                      {"values", {datum.undulations.columns, datum.undulations.rows}},
                      {"max_error_m", datum.undulations.max_error_m}};
  }
  if (scene.hasSea()) about["sea"] = true;
  if (!scene.inputs().empty()) about["inputs"] = ordered_json::array();
  for (const terrain::SceneInput& input : scene.inputs()) {
    const proto::LatticeWindow& w = input.window;
    ordered_json each{{"name", input.name}, {"window", {w.x, w.y, w.width, w.height}}};
    if (!input.vertical.empty()) each["vertical"] = input.vertical;
    if (!std::isnan(input.residual_m)) each["residual_m"] = input.residual_m;
    if (input.feather_m > 0) each["feather_m"] = input.feather_m;
    about["inputs"].push_back(std::move(each));
  }
  return about;
}

}  // namespace foreland::apps
