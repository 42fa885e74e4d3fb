#include "server/occlusion/proofs/block_proofs.h"

namespace foreland::server {

using proto::HiddenBlocks;

BlockProofs::BlockProofs(const proto::GridTopology& grid) : scales_(grid.shape().root_log2) {
  for (uint32_t scale = 0; scale < scales_.size(); ++scale) {
    const uint32_t side_log2 = scale + proto::BlockId::kSideLog2 + HiddenBlocks::kTileLog2 + kChunkLog2;
    scales_[scale].columns = (grid.maxX() >> side_log2) + 1;
    scales_[scale].chunks.resize(size_t{scales_[scale].columns} * ((grid.maxY() >> side_log2) + 1));
  }
}

BlockProofs::Tile BlockProofs::of(const proto::BlockId& block, uint32_t keyframe) {
  constexpr uint32_t kMask = (1u << kChunkLog2) - 1;
  const uint32_t x = block.x >> HiddenBlocks::kTileLog2, y = block.y >> HiddenBlocks::kTileLog2;
  Scale& scale = scales_[block.scale];
  auto& chunk = scale.chunks[size_t{y >> kChunkLog2} * scale.columns + (x >> kChunkLog2)];
  if (!chunk) {
    chunk = std::make_unique<Chunk>();
    ++chunks_;
  }
  chunk->keyframe = keyframe;
  const uint32_t tile = (y & kMask) << kChunkLog2 | (x & kMask);
  return {chunk->due[tile], chunk->proofs[tile]};
}

void BlockProofs::forgetUnused(uint32_t keyframe) {
  for (Scale& scale : scales_)
    for (auto& chunk : scale.chunks)
      if (chunk && chunk->keyframe < keyframe) {
        chunk.reset();
        --chunks_;
      }
}

size_t BlockProofs::bytes() const {
  size_t bytes = chunks_ * sizeof(Chunk);
  for (const Scale& scale : scales_) bytes += scale.chunks.capacity() * sizeof(scale.chunks[0]);
  return bytes;
}

}  // namespace foreland::server
