// A small planet as it is drawn at full resolution, and cameras above it.
#pragma once

#include <glm/geometric.hpp>
#include <vector>

#include "client/mesh/patch/keyframe_mesh.h"
#include "proto/space/frame_grid.h"
#include "proto/space/pose.h"
#include "terrain/store/scene.h"

namespace foreland::oracle {

// All vertices of a globe whose levels are all whole, with faces of so many steps, and two triangles for each cell.
inline client::KeyframeMesh wholeGlobe(const terrain::Scene& scene, uint32_t side) {
  const proto::GridTopology& grid = scene.grid();
  const proto::FrameGrid positions(scene.frame(), grid.maxX(), grid.maxY());
  client::KeyframeMesh mesh;
  std::vector<uint32_t> index(size_t{grid.maxX() + 1} * (grid.maxY() + 1), ~0u);
  const auto vertex = [&](uint32_t face, uint32_t x, uint32_t y) {
    const proto::NodeId name = grid.nameIn(face, proto::NodeId::at(face * side + x, y));
    uint32_t& found = index[size_t{name.y()} * (grid.maxX() + 1) + name.x()];
    if (found == ~0u) {
      found = static_cast<uint32_t>(mesh.parameters.size());
      mesh.parameters.emplace_back(name.x(), name.y());
      mesh.from_positions.emplace_back(glm::vec3(positions.position(name, scene.height(name))), 0);
    }
    return found;
  };
  for (uint32_t face = 0; face < 6; ++face)
    for (uint32_t y = 0; y < side; ++y)
      for (uint32_t x = 0; x < side; ++x) {
        const uint32_t sw = vertex(face, x, y), se = vertex(face, x + 1, y), nw = vertex(face, x, y + 1),
                       ne = vertex(face, x + 1, y + 1);
        for (const uint32_t v : {sw, se, ne, sw, ne, nw}) mesh.indices.push_back(v);
      }
  mesh.to_positions = mesh.from_positions;
  return mesh;
}

// From above a direction of a planet of tests/support/globe_scene.h, straight down.
inline proto::Pose viewFrom(const glm::dvec3& direction, double height_m) {
  const glm::dvec3 n = glm::normalize(direction);
  return {n * (20'000 + height_m), proto::lookAlong(-n, glm::normalize(glm::cross(n, glm::dvec3(0.2, 0.3, 0.9))))};
}

}  // namespace foreland::oracle
