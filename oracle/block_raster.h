// The oracle's rasteriser: drawn positions at lattice samples, block by block, from triangles given by lattice
// position. Blocks keep a tile in the processor's cache and make the work local. One owner.
#pragma once

#include <array>
#include <cstdint>
#include <glm/vec3.hpp>
#include <span>
#include <vector>

#include "client/mesh/patch/keyframe_mesh.h"

namespace foreland::oracle {

inline constexpr uint32_t kBlockLog2 = 5, kBlock = 1u << kBlockLog2;  // samples a side

// xyz, and nothing: so that the processor takes them as one.
struct alignas(32) Position {
  std::array<double, 4> at;
};

// Positions (scene frame, metres) at the samples of one block, and which of them lie under a triangle.
struct Tile {
  std::array<Position, kBlock * kBlock> position;
  std::array<uint32_t, kBlock> covered;  // by row; bit x
};

// Blocks of a grid of x times y. `rank` has an entry for each, row by row: -1 if it is not chosen, else its index among
// the `chosen` ones.
struct ChosenBlocks {
  std::span<const int32_t> rank;
  uint32_t x = 0, y = 0;
  size_t chosen = 0;
};

// A drawn mesh at one weight, ready to be rasterised in some blocks.
class BlockRaster {
 public:
  struct Corner {
    double x, y;          // place on the lattice
    glm::dvec3 position;  // times the share
  };

  // Of `share` times the mesh's position, mix(from, to, weight). The mesh is not needed afterwards.
  void build(const client::KeyframeMesh& mesh, double weight, double share, const ChosenBlocks& blocks);
  // Adds the position at every sample of the block under one of the triangles; samples on a shared edge count once.
  // `covered` is that of this mesh alone.
  void add(size_t chosen_block, uint32_t block_x, uint32_t block_y, Tile& tile,
           std::array<uint32_t, kBlock>& covered) const;

 private:
  struct Meeting {
    uint32_t triangle, block;
  };
  std::vector<Corner> corners_;                     // by vertex
  std::vector<Meeting> meetings_;                   // scratch of build()
  std::vector<uint32_t> first_;                     // by block, of its triangles
  std::vector<std::array<uint32_t, 3>> triangles_;  // by block, in the mesh's order
};

}  // namespace foreland::oracle
