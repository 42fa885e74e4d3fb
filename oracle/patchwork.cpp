#include "oracle/patchwork.h"

#include <algorithm>
#include <cmath>
#include <glm/common.hpp>
#include <set>
#include <tuple>
#include <utility>

namespace foreland::oracle {

namespace {

bool meets(const FaceTriangle& t, const PatchLattice& patch) {
  if (t.face != patch.face) return false;
  const glm::dvec2 low = glm::min(t.place[0], glm::min(t.place[1], t.place[2])),
                   high = glm::max(t.place[0], glm::max(t.place[1], t.place[2])),
                   end(patch.at(patch.size.x - 1, patch.size.y - 1));
  return low.x <= end.x && low.y <= end.y && high.x >= static_cast<double>(patch.first.x) &&
         high.y >= static_cast<double>(patch.first.y);
}

// The triangles of a mesh that meet a patch, as a mesh on its lattice.
client::KeyframeMesh laidOn(const PatchLattice& patch, const client::KeyframeMesh& mesh,
                            const std::vector<FaceTriangle>& triangles, std::vector<uint32_t>& scratch) {
  client::KeyframeMesh out;
  out.from = mesh.from;
  out.to = mesh.to;
  out.origin = mesh.origin;
  scratch.assign(mesh.parameters.size(), ~0u);
  for (const FaceTriangle& t : triangles) {
    if (!meets(t, patch)) continue;
    for (size_t k = 0; k < 3; ++k) {
      uint32_t& index = scratch[t.vertex[k]];
      if (index == ~0u) {
        index = static_cast<uint32_t>(out.parameters.size());
        out.parameters.emplace_back((t.place[k] - glm::dvec2(patch.first)) / static_cast<double>(patch.step));
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

// Deviations of patches, put together.
struct Sum {
  Deviation all;
  double px2 = 0, m2 = 0;

  // Whether the largest is this one's.
  bool add(const Deviation& d) {
    px2 += d.rms_px * d.rms_px * static_cast<double>(d.samples);
    m2 += d.rms_m * d.rms_m * static_cast<double>(d.samples);
    all.samples += d.samples;
    all.uncovered += d.uncovered;
    all.max_m = std::max(all.max_m, d.max_m);
    if (d.max_px <= all.max_px) return false;
    all.max_px = d.max_px;
    return true;
  }
  Deviation finish() {
    const auto count = static_cast<double>(std::max<uint64_t>(all.samples, 1));
    all.rms_px = std::sqrt(px2 / count), all.rms_m = std::sqrt(m2 / count);
    return all;
  }
};

// A face's last place: of a cube its side, else the data's.
Place lastOn(const proto::GridShape& shape) {
  if (shape.is_cube) return Place(int64_t{1} << shape.root_log2);
  return {int64_t{shape.samples_x} - 1, int64_t{shape.samples_y} - 1};
}

}  // namespace

std::vector<PatchLattice> patchesOf(const terrain::Scene& scene) {
  const proto::GridShape& shape = scene.grid().shape();
  const Place last = lastOn(shape);
  const uint32_t faces = shape.is_cube ? 6 : 1;
  const int64_t whole_step = int64_t{1} << (shape.sparse_levels / 2);
  std::vector<PatchLattice> out;
  for (uint32_t face = 0; face < faces; ++face)
    out.push_back({face, {0, 0}, whole_step, glm::uvec2(last / whole_step + Place(1)), true});
  // Centres and sides have blocks of their own, those of sides twice as many pages; so patches are of squares of pages
  // of centres, each taken once.
  std::set<std::tuple<int64_t, uint32_t, uint32_t>> taken;
  for (const proto::PageBlock& block : scene.pages().blocks()) {
    const int64_t step = int64_t{1} << (shape.root_log2 - 1 - static_cast<uint32_t>(block.level() / 2));
    const uint32_t row = block.level() % 2 == 0 ? block.row() : block.row() / 2;
    if (!taken.emplace(step, block.column(), row).second) continue;
    const int64_t side = int64_t{32} * 32 * step, x = block.column() * side, y = row * side;
    const int64_t face_side = shape.is_cube ? last.x : int64_t{shape.roots_x + 1} << shape.root_log2;
    for (int64_t face = x / face_side; face < faces && face * face_side < x + side; ++face) {
      const Place low(std::max(x - face * face_side, int64_t{0}), y),
          high = glm::min(Place(x + side - face * face_side, y + side), last);
      if (low.x > high.x || low.y > high.y) continue;
      out.push_back({static_cast<uint32_t>(face), low, step, glm::uvec2((high - low) / step + Place(1)), false});
    }
  }
  return out;
}

Patchwork::Patchwork(PatchworkTruth truth) : truth_(std::make_shared<const PatchworkTruth>(std::move(truth))) {
  for (const PatchLattice& lattice : truth_->patches) patches_.push_back({lattice, Oracle(truth_->of(lattice))});
  setSight({});
}
Patchwork::Patchwork(std::shared_ptr<const PatchworkTruth> truth, std::vector<Patch> patches)
    : truth_(std::move(truth)), patches_(std::move(patches)) {}
Patchwork::~Patchwork() = default;
Patchwork::Patchwork(Patchwork&&) noexcept = default;

Patchwork Patchwork::twin() {
  std::vector<Patch> twins;
  for (Patch& patch : patches_) twins.push_back({patch.lattice, patch.oracle.twin()});
  return Patchwork(truth_, std::move(twins));
}

void Patchwork::setSight(const Sight& sight) {
  Sight both = sight;
  if (truth_->may_be_seen)
    both.is_seen = [truth = truth_, other = sight.is_seen](const glm::dvec3& point, const glm::dvec3& eye) {
      return truth->may_be_seen(point, eye) && (!other || other(point, eye));
    };
  for (Patch& patch : patches_) patch.oracle.setSight(both);
}

void Patchwork::showAt(const TruthTime& time) {
  for (Patch& patch : patches_) patch.oracle.showAt(time);
}

std::span<const double> Patchwork::sharesShown() const { return patches_.front().oracle.sharesShown(); }

std::span<const Time> Patchwork::epochs() const { return patches_.front().oracle.epochs(); }

Deviation Patchwork::error(const client::KeyframeMesh& mesh, double weight, const proto::Pose& pose,
                           const proto::Lens& lens) {
  const DrawnShare drawn{.mesh = &mesh, .weight = weight};
  const Surface surface(&drawn, 1);
  return compare({&surface, 1}, {}, pose, lens);
}

Deviation Patchwork::difference(Surface a, Surface b, const proto::Pose& pose, const proto::Lens& lens) {
  const Surface both[] = {a, b};
  return compare(both, {0, 1}, pose, lens);
}

Deviation Patchwork::compare(std::span<const Surface> surfaces, SurfacePair pair, const proto::Pose& pose,
                             const proto::Lens& lens) {
  std::vector<std::vector<FaceTriangle>> triangles;  // of each share of each surface
  for (const Surface& surface : surfaces)
    for (const DrawnShare& share : surface) triangles.push_back(truth_->triangles(*share.mesh));
  std::vector<client::KeyframeMesh> meshes(triangles.size());
  std::vector<std::vector<DrawnShare>> laid(surfaces.size());
  std::vector<uint32_t> scratch;
  Sum sum;
  size_t held = 0;
  for (Patch& patch : patches_) {
    size_t k = 0;
    for (size_t i = 0; i < surfaces.size(); ++i) {
      laid[i].assign(surfaces[i].begin(), surfaces[i].end());
      for (DrawnShare& share : laid[i]) {
        meshes[k] = laidOn(patch.lattice, *share.mesh, triangles[k], scratch);
        share.mesh = &meshes[k++];
      }
    }
    const std::vector<Surface> on_patch(laid.begin(), laid.end());
    const Deviation d = patch.oracle.compare(on_patch, {&pair, 1}, pose, lens).front();
    if (held += patch.oracle.held(); held > kMostHeld) held -= patch.oracle.held(), patch.oracle.forget();
    if (sum.add(d))
      sum.all.worst_sample = truth_->sample(patch.lattice, patch.lattice.at(d.worst_sample.x, d.worst_sample.y));
  }
  return sum.finish();
}

}  // namespace foreland::oracle
