#include "oracle/sparse_oracle.h"

#include <utility>

#include "proto/space/frame_grid.h"

namespace foreland::oracle {

namespace {

proto::NodeId nodeAt(const Place& place) {
  return proto::NodeId::at(static_cast<uint32_t>(place.x), static_cast<uint32_t>(place.y));
}

struct SparseGround {
  std::shared_ptr<const terrain::Scene> scene;
  proto::FrameGrid positions;

  explicit SparseGround(std::shared_ptr<const terrain::Scene> s)
      : scene(std::move(s)), positions(scene->frame(), scene->grid().maxX(), scene->grid().maxY()) {}

  int32_t heightAt(const PatchLattice& patch, const Place& place) const {
    if (patch.isCoarser(place) && !patch.has_coarser) return kNoSample;
    const proto::GridTopology& grid = scene->grid();
    const proto::NodeId name = nodeAt(place);
    const int level = grid.level(name);
    if (level == 0) return proto::BaseHeights{scene->cornerHeights(), scene->centreHeights()}.at(grid, name);
    const uint64_t record = scene->pages().placeOf(grid.slot(name, level));
    return record == proto::PageDirectory::kNowhere ? kNoSample : scene->records()[record].height();
  }
};

Truth sparseTruth(const PatchLattice& patch, const std::shared_ptr<const SparseGround>& ground) {
  Truth truth;
  truth.is_read_on_demand = true;
  truth.shape.samples_x = patch.size.x;
  truth.shape.samples_y = patch.size.y;
  truth.heights = [ground, patch](uint32_t x, uint32_t y, std::span<int32_t> out) {
    for (uint32_t i = 0; i < out.size(); ++i) out[i] = ground->heightAt(patch, patch.at(x + i, y));
  };
  truth.position = [ground, patch](uint32_t x, uint32_t y, double height) {
    return ground->positions.position(nodeAt(patch.at(x, y)), height);
  };
  return truth;
}

std::vector<FaceTriangle> trianglesOnLattice(const client::KeyframeMesh& mesh) {
  std::vector<FaceTriangle> triangles(mesh.triangleCount());
  for (size_t t = 0; t < triangles.size(); ++t)
    for (size_t k = 0; k < 3; ++k) {
      const uint32_t v = mesh.indices[3 * t + k];
      triangles[t].vertex[k] = v;
      triangles[t].place[k] = glm::dvec2(mesh.parameters[v]);
    }
  return triangles;
}

}  // namespace

Patchwork sparseOracle(std::shared_ptr<const terrain::Scene> scene) {
  const auto ground = std::make_shared<const SparseGround>(std::move(scene));
  return Patchwork({.patches = patchesOf(*ground->scene),
                    .of = [ground](const PatchLattice& patch) { return sparseTruth(patch, ground); },
                    .triangles = trianglesOnLattice,
                    .sample = [](const PatchLattice&, const Place& place) { return glm::uvec2(place); }});
}

}  // namespace foreland::oracle
