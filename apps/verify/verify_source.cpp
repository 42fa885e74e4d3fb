#include "apps/verify/verify_source.h"

#include <algorithm>
#include <cinttypes>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <utility>

#include "apps/verify/verify_globe.h"
#include "terrain/dem/compare_source.h"
#include "terrain/dem/vertical/height_reference.h"
#include "terrain/store/scene.h"

namespace foreland::apps {

namespace {

constexpr double kRounding_m = 1e-3;  // of floats that heights were in when the residual was measured

struct Source {
  std::filesystem::path file;
  terrain::OpenOptions open;
};

Source sourceOf(const std::string& text, const terrain::Scene& scene, const ForeignFiles& foreign) {
  constexpr std::string_view kVertical = "@vertical=";
  Source source{text, {}};
  if (const size_t at = text.rfind(kVertical); at != std::string::npos) {
    source.file = text.substr(0, at);
    source.open.vertical_of[source.file.string()] = text.substr(at + kVertical.size());
  }
  if (const std::string choice = terrain::choiceNamed(scene.vertical().name); !choice.empty())
    source.open.scene_vertical = choice;
  source.open.allowed_folders = foreign.allowed;
  return source;
}

Result<size_t> indexOf(const terrain::Scene& scene, const std::string& name) {
  const auto& inputs = scene.inputs();
  const auto input = std::ranges::find(inputs, name, &terrain::SceneInput::name);
  if (input != inputs.end()) return static_cast<size_t>(input - inputs.begin());
  return Error{
      ErrorCode::kInvalidArgument,
      name + (inputs.empty() ? ": the scene does not state its inputs, as those of one grid without a datum do "
                               "not; their heights are the samples'"
                             : ": the scene names no such input; see foreland info")};
}

Result<terrain::SourceExtent> extentIn(const terrain::Scene& scene, const std::string& name) {
  const auto index = indexOf(scene, name);
  if (!index.ok()) return index.error();
  terrain::SourceExtent extent{.feather_m = scene.inputs()[*index].feather_m};
  for (size_t i = 0; i < *index; ++i) extent.above.push_back(scene.inputs()[i].window);
  return extent;
}

// Whether it is as close as is stated.
bool judge(const terrain::Scene& scene, const terrain::SourceDifference& found) {
  const auto index = indexOf(scene, found.name);
  const double stated_m = index.ok() ? scene.inputs()[*index].residual_m : std::nan("");
  std::printf("%s: at %" PRIu64 " samples within %.4g m", found.name.c_str(), found.compared, found.largest_m);
  if (std::isnan(stated_m))
    std::printf(", nothing is stated");
  else
    std::printf(", %.4g m are stated", stated_m);
  std::printf("; %" PRIu64 " were left out, where it does not count alone\n", found.left_out);
  if (std::isnan(stated_m) || found.largest_m <= stated_m + kRounding_m) return true;
  std::fprintf(stderr, "foreland verify: %s: the scene is %.4g m off it, and states %.4g m\n", found.name.c_str(),
               found.largest_m, stated_m);
  return false;
}

}  // namespace

Result<uint64_t> verifySources(const std::string& path, const std::vector<std::string>& sources,
                               const ForeignFiles& foreign) {
  const auto scene = terrain::Scene::open(path);
  if (!scene.ok()) return scene.error();
  const terrain::Scene& s = **scene;
  if (s.grid().isCube() && !sources.empty()) return verifyGlobeSources(s, sources, foreign);
  const proto::GridShape& shape = s.grid().shape();
  const double quantum_m = s.frame().height_quantum_m;
  const terrain::LatticeHeights heights{
      {s.frame(), shape.samples_x, shape.samples_y, s.origin().crs_wkt, path},
      [&s, quantum_m](uint32_t x, uint32_t y) { return s.height(proto::NodeId::at(x, y)) * quantum_m; }};
  uint64_t faults = 0;
  for (const std::string& text : sources) {
    const Source source = sourceOf(text, s, foreign);
    const auto found = terrain::compareSource(source.file, source.open, heights,
                                              [&](const std::string& name) { return extentIn(s, name); });
    if (!found.ok()) return found.error();
    for (const terrain::SourceDifference& difference : *found) faults += judge(s, difference) ? 0 : 1;
  }
  return faults;
}

}  // namespace foreland::apps
