#include "oracle/globe/source_samples.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <numbers>
#include <optional>

#include "oracle/globe/cube_faces.h"
#include "terrain/geo/geodesy.h"

namespace foreland::oracle {

namespace {

constexpr uint32_t kSide = 16;       // of a block, samples
constexpr uint32_t kSmallHole = 50;  // holes with at most one in so many of a raster's samples are filled
constexpr double kRadian = std::numbers::pi / 180;

struct Cone {
  glm::dvec3 middle{0, 0, 1};
  double angle_rad = std::numbers::pi;

  bool holds(const glm::dvec3& direction, double reach_rad) const {
    return std::atan2(glm::length(glm::cross(middle, direction)), glm::dot(middle, direction)) <= angle_rad + reach_rad;
  }
};

proto::Geodetic geodetic(const SourceRaster& raster, size_t i) {
  return {raster.degrees[i].y * kRadian, raster.degrees[i].x * kRadian, raster.metres[i]};
}

glm::dvec3 normalAt(const proto::Geodetic& at) {
  return {std::cos(at.latitude_rad) * std::cos(at.longitude_rad),
          std::cos(at.latitude_rad) * std::sin(at.longitude_rad), std::sin(at.latitude_rad)};
}

bool isThere(const SourceRaster& raster, size_t i) {
  return !std::isnan(raster.metres[i]) && !std::isnan(raster.degrees[i].x);
}

Cone coneAround(const SourceRaster& raster) {
  glm::dvec3 sum(0);
  double count = 0;
  for (size_t i = 0; i < raster.metres.size(); ++i)
    if (isThere(raster, i)) sum += normalAt(geodetic(raster, i)), ++count;
  Cone cone;
  if (!(glm::length(sum) > 0.1 * count)) return cone;  // around the body
  cone.middle = glm::normalize(sum);
  double least = 1;
  for (size_t i = 0; i < raster.metres.size(); ++i)
    if (isThere(raster, i)) least = std::min(least, glm::dot(cone.middle, normalAt(geodetic(raster, i))));
  cone.angle_rad = std::acos(least) * 1.01;
  return cone;
}

// Where a raster's edges are: samples that are not there, but for small holes inside of it. Counted in rectangles.
class Edges {
 public:
  explicit Edges(const SourceRaster& raster) : width_(raster.width), height_(raster.height) {
    std::vector<bool> is_edge(raster.metres.size());
    for (size_t i = 0; i < is_edge.size(); ++i) is_edge[i] = !isThere(raster, i);
    fillHoles(is_edge);
    counts_.assign((width_ + 1) * (height_ + 1), 0);
    for (size_t y = 0; y < height_; ++y)
      for (size_t x = 0; x < width_; ++x)
        counts_[(y + 1) * (width_ + 1) + x + 1] =
            (is_edge[y * width_ + x] ? 1 : 0) + at(x, y + 1) + at(x + 1, y) - at(x, y);
  }
  // Whether one is within so many columns and rows of a sample, the raster's border included.
  bool areNear(size_t x, size_t y, size_t columns, size_t rows) const {
    if (x < columns || y < rows || x + columns >= width_ || y + rows >= height_) return true;
    const size_t x0 = x - columns, y0 = y - rows, x1 = x + columns + 1, y1 = y + rows + 1;
    return at(x1, y1) + at(x0, y0) != at(x0, y1) + at(x1, y0);
  }

 private:
  uint64_t at(size_t x, size_t y) const { return counts_[y * (width_ + 1) + x]; }

  // Holes are connected by sides and corners; those at the border stay.
  void fillHoles(std::vector<bool>& is_edge) const {
    std::vector<bool> is_known(is_edge.size());
    std::vector<size_t> hole;
    for (size_t start = 0; start < is_edge.size(); ++start) {
      if (!is_edge[start] || is_known[start]) continue;
      bool is_at_border = false;
      hole.assign(1, start);
      is_known[start] = true;
      for (size_t k = 0; k < hole.size(); ++k) {
        const size_t x = hole[k] % width_, y = hole[k] / width_;
        is_at_border |= x == 0 || y == 0 || x + 1 == width_ || y + 1 == height_;
        for (size_t v = y - (y > 0); v <= std::min(y + 1, height_ - 1); ++v)
          for (size_t u = x - (x > 0); u <= std::min(x + 1, width_ - 1); ++u) {
            const size_t next = v * width_ + u;
            if (!is_edge[next] || is_known[next]) continue;
            is_known[next] = true;
            hole.push_back(next);
          }
      }
      if (is_at_border || hole.size() > is_edge.size() / kSmallHole) continue;
      for (const size_t i : hole) is_edge[i] = false;
    }
  }

  size_t width_, height_;
  std::vector<uint64_t> counts_;  // of edges before a column and a row
};

// The shortest distances between neighbours along rows and along columns, metres.
glm::dvec2 shortestSteps(const SourceRaster& raster, const terrain::Ellipsoid& ellipsoid) {
  glm::dvec2 shortest(INFINITY);
  const auto length = [&](size_t i, size_t j) {
    proto::Geodetic a = geodetic(raster, i), b = geodetic(raster, j);
    a.height_m = b.height_m = 0;
    const double d = glm::distance(terrain::referencePosition(ellipsoid, a), terrain::referencePosition(ellipsoid, b));
    return d > 0 ? d : INFINITY;
  };
  for (size_t y = 0; y + 1 < raster.height; y += 1 + raster.height / 64)
    for (size_t x = 0; x + 1 < raster.width; x += 1 + raster.width / 64) {
      const size_t i = y * raster.width + x;
      shortest.x = std::min(shortest.x, length(i, i + 1));
      shortest.y = std::min(shortest.y, length(i, i + raster.width));
    }
  return shortest;
}

class Selection {
 public:
  Selection(const terrain::Scene& scene, const std::vector<SourceRaster>& rasters)
      : scene_(scene),
        rasters_(rasters),
        cube_(scene.grid().shape().root_log2),
        ellipsoid_{scene.frame().semi_major_m, scene.frame().flattening} {
    for (const SourceRaster& raster : rasters) cones_.push_back(coneAround(raster));
  }

  void add(size_t index, std::vector<SourceBlock>& out) const {
    const SourceRaster& raster = rasters_[index];
    const terrain::SceneInput& input = scene_.inputs()[raster.input];
    if (std::isnan(input.residual_m)) return;
    std::optional<Edges> edges;  // a base has none
    if (input.may_have_voids) edges.emplace(raster);
    const glm::dvec2 steps = shortestSteps(raster, ellipsoid_);
    for (uint32_t row = 0; row < raster.height; row += kSide)
      for (uint32_t column = 0; column < raster.width; column += kSide) {
        SourceBlock block{raster.input, {}};
        for (uint32_t y = row; y < std::min(row + kSide, raster.height); ++y)
          for (uint32_t x = column; x < std::min(column + kSide, raster.width); ++x)
            if (isAlone(index, x, y, edges ? &*edges : nullptr, steps, input.feather_m))
              block.samples.push_back(geodetic(raster, size_t{y} * raster.width + x));
        if (!block.samples.empty()) out.push_back(std::move(block));
      }
  }

 private:
  // With all corners of the triangles of the ground around it.
  bool isAlone(size_t index, uint32_t x, uint32_t y, const Edges* edges, glm::dvec2 steps, double feather_m) const {
    const SourceRaster& raster = rasters_[index];
    const size_t i = size_t{y} * raster.width + x;
    if (!isThere(raster, i) || std::fabs(raster.degrees[i].y) > 90 - 1e-9) return false;  // a pole has one height
    const glm::dvec3 normal = normalAt(geodetic(raster, i));
    const auto [face, place] = cube_.placeOf(normal);
    const double reach_m = longestEdgeAt(scene_, face, place) * longestStep(scene_.frame());
    if (edges) {
      const glm::dvec2 away = (feather_m + reach_m) / steps + 2.0;
      if (!(std::max(away.x, away.y) < 1e9)) return false;
      if (edges->areNear(x, y, static_cast<size_t>(away.x), static_cast<size_t>(away.y))) return false;
    }
    for (size_t j = 0; j < rasters_.size(); ++j)
      if (rasters_[j].input < raster.input && cones_[j].holds(normal, 1.01 * reach_m / ellipsoid_.semi_major_m))
        return false;
    return true;
  }

  const terrain::Scene& scene_;
  const std::vector<SourceRaster>& rasters_;
  CubeFaces cube_;
  terrain::Ellipsoid ellipsoid_;
  std::vector<Cone> cones_;
};

}  // namespace

// Where the centre of a square of the lattice is a vertex, triangles in the square are no longer than its side.
double longestEdgeAt(const terrain::Scene& scene, uint32_t face, glm::dvec2 place) {
  const proto::GridTopology& grid = scene.grid();
  const auto side = static_cast<int64_t>(grid.rootSize()), whole = int64_t{1} << (grid.shape().sparse_levels / 2);
  const CubeFaces cube(grid.shape().root_log2);
  for (int64_t step = 1; step < whole; step *= 2) {
    const auto centre = [&](double v) {
      return std::clamp(static_cast<int64_t>(v) / (2 * step) * 2 * step, int64_t{0}, side - 2 * step) + step;
    };
    const proto::NodeId name = cube.nameOf(cube.pointOn(face, {centre(place.x), centre(place.y)}));
    if (scene.pages().hasPage(grid.slot(name, grid.level(name)))) return 2.0 * static_cast<double>(step);
  }
  return 2.0 * static_cast<double>(whole);
}

// An edge of a face is pi / 2 long in 2^k steps; the map's steps differ from their mean by less than a twentieth.
double longestStep(const proto::Frame& frame) {
  const double polar = frame.semi_major_m * (1 - frame.flattening);
  const double widest_m = std::max(frame.semi_major_m * frame.semi_major_m / polar, frame.semi_major_m);
  return 1.05 * 0.5 * std::numbers::pi * widest_m / frame.face_steps;
}

std::vector<SourceBlock> samplesAlone(const terrain::Scene& scene, const std::vector<SourceRaster>& rasters) {
  const Selection selection(scene, rasters);
  std::vector<SourceBlock> out;
  for (size_t i = 0; i < rasters.size(); ++i) selection.add(i, out);
  return out;
}

}  // namespace foreland::oracle
