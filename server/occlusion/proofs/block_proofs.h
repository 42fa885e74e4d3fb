// What a viewer's server remembers of blocks of which it has said whether they are hidden (viewer_occlusion.h): by
// tiles, as HiddenBlocks keeps them, however large the scene is. One owner. Memory: 400 bytes a tile, in chunks of 16
// that are freed once unused.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <vector>

#include "proto/refine/hidden/hidden_blocks.h"
#include "proto/section/index_table.h"
#include "server/occlusion/proofs/span_proof.h"

namespace foreland::server {

struct TileProofs {
  static constexpr uint32_t kBlocks = proto::HiddenBlocks::kTileBlocks;
  std::array<int32_t, kBlocks> next{};  // the interval of each block's next review; apart, for most are not due
  std::array<SpanProof, kBlocks> blocks;
};

// Whether any block of a tile is due. Side by side for neighbouring tiles, for most have none.
struct TileDue {
  int32_t first = 0;      // the first of its blocks' next reviews; at most
  uint32_t revision = 0;  // of the spans, at the last review
};

class BlockProofs {
 public:
  struct Tile {
    TileDue& due;
    TileProofs& proofs;
  };
  // The tile that holds a block; new if there is none.
  Tile of(const proto::BlockId& block, uint32_t keyframe);
  // Forgets chunks that were last asked for before `keyframe`.
  void forgetUnused(uint32_t keyframe);
  size_t bytes() const;  // in constant time

 private:
  static constexpr uint32_t kChunkLog2 = 2;  // of a chunk's side, in tiles
  static constexpr uint32_t kChunkTiles = 1u << (2 * kChunkLog2);
  struct Chunk {
    uint64_t key = 0;
    uint32_t keyframe = 0;
    std::array<TileDue, kChunkTiles> due;
    std::array<TileProofs, kChunkTiles> proofs;
  };
  proto::IndexTable numbers_;                   // of chunks, by key
  std::vector<std::unique_ptr<Chunk>> chunks_;  // by number, the first of which is 1
};

}  // namespace foreland::server
