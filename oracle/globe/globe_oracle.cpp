#include "oracle/globe/globe_oracle.h"

#include <algorithm>
#include <cmath>
#include <glm/common.hpp>
#include <set>
#include <tuple>
#include <utility>

#include "oracle/globe/cube_faces.h"

namespace foreland::oracle {

namespace {

using Place = glm::vec<2, int64_t>;

// A lattice of its own on a face: places first + step * (x, y), of which those count that are vertices of some levels.
struct PatchLattice {
  uint32_t face = 0;
  Place first{0, 0};
  int64_t step = 1;
  glm::uvec2 size{2, 2};
  bool has_coarser = false;  // whether vertices of coarser levels than the step's count, too

  Place at(uint32_t x, uint32_t y) const { return first + step * Place(x, y); }
};

// A triangle of a mesh on a face's square.
struct FaceTriangle {
  uint32_t face;
  std::array<uint32_t, 3> vertex;
  std::array<Place, 3> place;

  bool meets(const PatchLattice& patch) const {
    if (face != patch.face) return false;
    const Place low = glm::min(place[0], glm::min(place[1], place[2])),
                high = glm::max(place[0], glm::max(place[1], place[2])),
                end = patch.at(patch.size.x - 1, patch.size.y - 1);
    return low.x <= end.x && low.y <= end.y && high.x >= patch.first.x && high.y >= patch.first.y;
  }
};

std::vector<FaceTriangle> trianglesOf(const client::KeyframeMesh& mesh, const CubeFaces& cube) {
  std::vector<CubeFaces::Point> points;
  for (const glm::vec2& p : mesh.parameters)
    points.push_back(cube.pointOf(proto::NodeId::at(static_cast<uint32_t>(p.x), static_cast<uint32_t>(p.y))));
  std::vector<FaceTriangle> triangles;
  for (size_t i = 0; i < mesh.indices.size(); i += 3) {
    FaceTriangle t{0, {mesh.indices[i], mesh.indices[i + 1], mesh.indices[i + 2]}, {}};
    const auto face = CubeFaces::faceOf(points[t.vertex[0]], points[t.vertex[1]], points[t.vertex[2]], cube.side());
    if (!face) continue;  // what it should cover is uncovered
    t.face = *face;
    for (size_t k = 0; k < 3; ++k) t.place[k] = cube.placeOn(*face, points[t.vertex[k]]);
    triangles.push_back(t);
  }
  return triangles;
}

// Those of a patch, as a mesh on its lattice.
client::KeyframeMesh laidOn(const PatchLattice& patch, const client::KeyframeMesh& mesh,
                            const std::vector<FaceTriangle>& triangles, std::vector<uint32_t>& scratch) {
  client::KeyframeMesh out;
  out.from = mesh.from;
  out.to = mesh.to;
  out.origin = mesh.origin;
  scratch.assign(mesh.parameters.size(), ~0u);
  for (const FaceTriangle& t : triangles) {
    if (!t.meets(patch)) continue;
    for (size_t k = 0; k < 3; ++k) {
      uint32_t& index = scratch[t.vertex[k]];
      if (index == ~0u) {
        index = static_cast<uint32_t>(out.parameters.size());
        const glm::dvec2 place = glm::dvec2(t.place[k] - patch.first) / static_cast<double>(patch.step);
        out.parameters.emplace_back(place);
        out.from_positions.push_back(mesh.from_positions[t.vertex[k]]);
        out.to_positions.push_back(mesh.to_positions[t.vertex[k]]);
        if (mesh.from_bends.empty()) continue;
        out.from_bends.push_back(mesh.from_bends[t.vertex[k]]);
        out.to_bends.push_back(mesh.to_bends[t.vertex[k]]);
      }
    }
    for (const uint32_t v : t.vertex) out.indices.push_back(scratch[v]);
  }
  return out;
}

}  // namespace

struct GlobeOracle::Shared {
  std::shared_ptr<const terrain::Scene> scene;
  CubeFaces cube;
  terrain::Ellipsoid ellipsoid, lowest;  // that of the frame, and one that no ground reaches into

  explicit Shared(std::shared_ptr<const terrain::Scene> s)
      : scene(std::move(s)), cube(scene->grid().shape().root_log2) {
    const proto::Frame& frame = scene->frame();
    ellipsoid = {frame.semi_major_m, frame.flattening};
    // A metre for rounding; it is flatter than a surface of constant height.
    const double depth_m = std::min(0, scene->heightRange().lowest) * frame.height_quantum_m - 1,
                 polar_m = frame.semi_major_m * (1 - frame.flattening) + depth_m;
    lowest.semi_major_m = frame.semi_major_m + depth_m;
    lowest.flattening = 1 - polar_m / lowest.semi_major_m;
  }

  proto::NodeId nameOf(uint32_t face, const Place& place) const { return cube.nameOf(cube.pointOn(face, place)); }
  // Whether a vertex is there, of the patch's levels.
  bool counts(const PatchLattice& patch, const Place& place, proto::NodeId name) const {
    const proto::GridTopology& grid = scene->grid();
    const bool is_coarser = ((place.x | place.y) & (2 * patch.step - 1)) == 0;
    if (is_coarser && !patch.has_coarser) return false;
    const int level = grid.level(name);
    return level == 0 || scene->pages().hasPage(grid.slot(name, level));
  }

  Truth truthOf(const PatchLattice& patch, const std::shared_ptr<const Shared>& self) const {
    Truth truth;
    truth.shape.samples_x = patch.size.x;
    truth.shape.samples_y = patch.size.y;
    truth.heights = [self, patch](uint32_t x, uint32_t y, std::span<int32_t> out) {
      for (uint32_t i = 0; i < out.size(); ++i) {
        const Place place = patch.at(x + i, y);
        const proto::NodeId name = self->nameOf(patch.face, place);
        out[i] = self->counts(patch, place, name) ? self->scene->height(name) : kNoSample;
      }
    };
    truth.position = [self, patch](uint32_t x, uint32_t y, double height) {
      proto::Geodetic at = self->cube.geodetic(patch.face, glm::dvec2(patch.at(x, y)));
      at.height_m = height * self->scene->frame().height_quantum_m;
      return terrain::referencePosition(self->ellipsoid, at);
    };
    return truth;
  }
};

struct GlobeOracle::Patch {
  PatchLattice lattice;
  Oracle oracle;
};

namespace {

std::vector<PatchLattice> latticesOf(const terrain::Scene& scene) {
  const proto::GridTopology& grid = scene.grid();
  const int64_t side = int64_t{1} << grid.shape().root_log2,
                whole_step = int64_t{1} << (grid.shape().sparse_levels / 2);
  std::vector<PatchLattice> out;
  const auto count = static_cast<uint32_t>(side / whole_step) + 1;
  for (uint32_t face = 0; face < 6; ++face) out.push_back({face, {0, 0}, whole_step, {count, count}, true});
  // Centres and sides have blocks of their own, those of sides twice as many pages; so patches are of squares of pages
  // of centres, each taken once.
  std::set<std::tuple<int64_t, uint32_t, uint32_t>> taken;
  for (const proto::PageBlock& block : scene.pages().blocks()) {
    const int64_t step = int64_t{1} << (grid.shape().root_log2 - 1 - static_cast<uint32_t>(block.level() / 2));
    const uint32_t row = block.level() % 2 == 0 ? block.row() : block.row() / 2;
    if (!taken.emplace(step, block.column(), row).second) continue;
    const int64_t block_side = int64_t{32} * 32 * step;
    const int64_t x = block.column() * block_side, y = row * block_side;
    for (int64_t face = x / side; face * side < std::min(x + block_side, 6 * side); ++face) {
      const int64_t x0 = std::max(x - face * side, int64_t{0}), x1 = std::min(x + block_side - face * side, side),
                    y1 = std::min(y + block_side, side);
      out.push_back(
          {static_cast<uint32_t>(face), {x0, y}, step, glm::uvec2((x1 - x0) / step + 1, (y1 - y) / step + 1), false});
    }
  }
  return out;
}

}  // namespace

GlobeOracle::GlobeOracle(std::shared_ptr<const terrain::Scene> scene)
    : shared_(std::make_shared<const Shared>(std::move(scene))) {
  for (const PatchLattice& lattice : latticesOf(*shared_->scene))
    patches_.push_back({lattice, Oracle(shared_->truthOf(lattice, shared_))});
  setSight({});
}
GlobeOracle::GlobeOracle(std::shared_ptr<const Shared> shared, std::vector<Patch> patches)
    : shared_(std::move(shared)), patches_(std::move(patches)) {}
GlobeOracle::~GlobeOracle() = default;
GlobeOracle::GlobeOracle(GlobeOracle&&) noexcept = default;

GlobeOracle GlobeOracle::twin() {
  std::vector<Patch> twins;
  for (Patch& patch : patches_) twins.push_back({patch.lattice, patch.oracle.twin()});
  return GlobeOracle(shared_, std::move(twins));
}

void GlobeOracle::setSight(const Sight& sight) {
  const auto is_seen = [shared = shared_, other = sight.is_seen](const glm::dvec3& point, const glm::dvec3& eye) {
    return !isBehind(shared->lowest, eye, point) && (!other || other(point, eye));
  };
  for (Patch& patch : patches_) patch.oracle.setSight({is_seen, sight.limit_px});
}

Deviation GlobeOracle::error(const client::KeyframeMesh& mesh, double weight, const proto::Pose& pose,
                             const proto::Lens& lens) {
  const std::vector<FaceTriangle> triangles = trianglesOf(mesh, shared_->cube);
  std::vector<uint32_t> scratch;
  Deviation all;
  double px2 = 0, m2 = 0;
  for (Patch& patch : patches_) {
    const client::KeyframeMesh laid = laidOn(patch.lattice, mesh, triangles, scratch);
    const DrawnShare drawn{.mesh = &laid, .weight = weight};
    const Deviation d = patch.oracle.error({&drawn, 1}, pose, lens);
    px2 += d.rms_px * d.rms_px * static_cast<double>(d.samples);
    m2 += d.rms_m * d.rms_m * static_cast<double>(d.samples);
    all.samples += d.samples;
    all.uncovered += d.uncovered;
    all.max_m = std::max(all.max_m, d.max_m);
    if (d.max_px <= all.max_px) continue;
    all.max_px = d.max_px;
    const proto::NodeId worst =
        shared_->nameOf(patch.lattice.face, patch.lattice.at(d.worst_sample.x, d.worst_sample.y));
    all.worst_sample = {worst.x(), worst.y()};
  }
  const auto count = static_cast<double>(std::max<uint64_t>(all.samples, 1));
  all.rms_px = std::sqrt(px2 / count), all.rms_m = std::sqrt(m2 / count);
  return all;
}

}  // namespace foreland::oracle
