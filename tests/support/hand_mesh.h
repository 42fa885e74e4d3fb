// Small meshes made by hand, for tests of code that judges or writes meshes: a square lattice of vertices over flat
// ground.
#pragma once

#include <cstdint>

#include "client/mesh/patch/keyframe_mesh.h"
#include "proto/topology/grid.h"

namespace foreland::test {

inline proto::GridShape squareShape(uint32_t root_log2) {
  const uint32_t samples = (1u << root_log2) + 1;
  return {.roots_x = 1, .roots_y = 1, .root_log2 = root_log2, .samples_x = samples, .samples_y = samples};
}

// (cells + 1)^2 vertices, `step` samples apart, at height 0; each cell halved by the diagonal that rises. One sample is
// one metre and lattice (0, 0) the origin.
inline client::KeyframeMesh flatMesh(uint32_t cells, uint32_t step) {
  client::KeyframeMesh mesh;
  for (uint32_t y = 0; y <= cells; ++y)
    for (uint32_t x = 0; x <= cells; ++x) {
      const float px = static_cast<float>(x * step), py = static_cast<float>(y * step);
      mesh.parameters.emplace_back(px, py);
      mesh.from_positions.emplace_back(px, py, 0, 0);
      mesh.to_positions.emplace_back(px, py, 0, 0);
    }
  for (uint32_t y = 0; y < cells; ++y)
    for (uint32_t x = 0; x < cells; ++x) {
      const uint32_t a = y * (cells + 1) + x, b = a + 1, c = a + cells + 1, d = c + 1;
      for (uint32_t i : {a, b, d, a, d, c}) mesh.indices.push_back(i);
    }
  return mesh;
}

}  // namespace foreland::test
