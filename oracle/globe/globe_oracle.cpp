#include "oracle/globe/globe_oracle.h"

#include <utility>

#include "oracle/globe/cube_faces.h"
#include "oracle/globe/faces_of_mesh.h"

namespace foreland::oracle {

namespace {

struct Globe {
  std::shared_ptr<const terrain::Scene> scene;
  CubeFaces cube;
  terrain::Ellipsoid ellipsoid, lowest;  // that of the frame, and one that no ground reaches into

  explicit Globe(std::shared_ptr<const terrain::Scene> s) : scene(std::move(s)), cube(scene->grid().shape().root_log2) {
    ellipsoid = {scene->frame().semi_major_m, scene->frame().flattening};
    lowest = lowestEllipsoid(*scene);
  }

  proto::NodeId nameOf(uint32_t face, const Place& place) const { return cube.nameOf(cube.pointOn(face, place)); }
  // Whether a vertex is there, of the patch's levels.
  bool counts(const PatchLattice& patch, const Place& place, proto::NodeId name) const {
    if (patch.isCoarser(place) && !patch.has_coarser) return false;
    const proto::GridTopology& grid = scene->grid();
    const int level = grid.level(name);
    return level == 0 || scene->pages().hasPage(grid.slot(name, level));
  }
};

Truth globeTruth(const PatchLattice& patch, const std::shared_ptr<const Globe>& globe) {
  Truth truth;
  truth.is_read_on_demand = true;
  truth.shape.samples_x = patch.size.x;
  truth.shape.samples_y = patch.size.y;
  truth.heights = [globe, patch](uint32_t x, uint32_t y, std::span<int32_t> out) {
    for (uint32_t i = 0; i < out.size(); ++i) {
      const Place place = patch.at(x + i, y);
      const proto::NodeId name = globe->nameOf(patch.face, place);
      out[i] = globe->counts(patch, place, name) ? globe->scene->height(name) : kNoSample;
    }
  };
  truth.position = [globe, patch](uint32_t x, uint32_t y, double height) {
    proto::Geodetic at = globe->cube.geodetic(patch.face, glm::dvec2(patch.at(x, y)));
    at.height_m = height * globe->scene->frame().height_quantum_m;
    return terrain::referencePosition(globe->ellipsoid, at);
  };
  return truth;
}

}  // namespace

Patchwork globeOracle(std::shared_ptr<const terrain::Scene> scene) {
  const auto globe = std::make_shared<const Globe>(std::move(scene));
  return Patchwork(
      {.patches = patchesOf(*globe->scene),
       .of = [globe](const PatchLattice& patch) { return globeTruth(patch, globe); },
       .triangles = [globe](const client::KeyframeMesh& mesh) { return trianglesOnFaces(mesh, globe->cube); },
       .sample =
           [globe](const PatchLattice& patch, const Place& place) {
             const proto::NodeId name = globe->nameOf(patch.face, place);
             return glm::uvec2(name.x(), name.y());
           },
       .may_be_seen = [globe](const glm::dvec3& point,
                              const glm::dvec3& eye) { return !isBehind(globe->lowest, eye, point); }});
}

}  // namespace foreland::oracle
