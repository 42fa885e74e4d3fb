// The oracle's rasteriser: drawn positions at lattice samples, block by block, from triangles given by lattice
// position. Blocks keep a tile in the processor's cache and make the work local. One owner.
#pragma once

#include <array>
#include <cstdint>
#include <glm/vec3.hpp>
#include <span>
#include <vector>

#include "client/mesh/keyframe_mesh.h"

namespace foreland::oracle {

inline constexpr uint32_t kBlockLog2 = 5, kBlock = 1u << kBlockLog2;  // samples a side

// Positions (scene frame, metres) at the samples of one block, and which of them lie under a triangle.
struct Tile {
  std::array<std::array<double, kBlock * kBlock>, 3> position;
  std::array<uint32_t, kBlock> covered;  // by row; bit x
};

// Which triangles meet which of some chosen blocks.
class TriangleBins {
 public:
  // `rank` has an entry per block of the grid, row by row: -1 for blocks that are not chosen, else its index among the
  // chosen.
  void build(const client::KeyframeMesh& mesh, std::span<const int32_t> rank, uint32_t blocks_x, uint32_t blocks_y,
             size_t chosen);
  std::span<const uint32_t> triangles(size_t chosen_block) const {
    return std::span(triangles_).subspan(first_[chosen_block], first_[chosen_block + 1] - first_[chosen_block]);
  }

 private:
  std::vector<uint32_t> first_, triangles_;
};

// Adds `share` times the mesh's position, mix(from, to, weight), at every sample of the block under one of `triangles`;
// samples on a shared edge count once. `covered` is that of this mesh alone.
void rasterise(const client::KeyframeMesh& mesh, double weight, double share, std::span<const uint32_t> triangles,
               uint32_t block_x, uint32_t block_y, Tile& tile, std::array<uint32_t, kBlock>& covered);

}  // namespace foreland::oracle
