#include "server/occlusion/proofs/block_proofs.h"

namespace foreland::server {

using proto::HiddenBlocks;

BlockProofs::Tile BlockProofs::of(const proto::BlockId& block, uint32_t keyframe) {
  constexpr uint32_t kMask = (1u << kChunkLog2) - 1, kKeyLog2 = 28;
  const uint32_t x = block.x >> HiddenBlocks::kTileLog2, y = block.y >> HiddenBlocks::kTileLog2;
  const uint64_t key = (uint64_t{block.scale} << kKeyLog2 | y >> kChunkLog2) << kKeyLog2 | x >> kChunkLog2;
  uint32_t number = numbers_.find(key);
  if (number == proto::IndexTable::kNone) {
    chunks_.push_back(std::make_unique<Chunk>());
    chunks_.back()->key = key;
    number = static_cast<uint32_t>(chunks_.size());
    numbers_.insert(key, number);
  }
  Chunk& chunk = *chunks_[number - 1];
  chunk.keyframe = keyframe;
  const uint32_t tile = (y & kMask) << kChunkLog2 | (x & kMask);
  return {chunk.due[tile], chunk.proofs[tile]};
}

void BlockProofs::forgetUnused(uint32_t keyframe) {
  std::erase_if(chunks_, [keyframe](const auto& chunk) { return chunk->keyframe < keyframe; });
  numbers_.reset(chunks_.size());
  for (size_t i = 0; i < chunks_.size(); ++i) numbers_.insert(chunks_[i]->key, static_cast<uint32_t>(i + 1));
}

size_t BlockProofs::bytes() const {
  return chunks_.size() * sizeof(Chunk) + chunks_.capacity() * sizeof(chunks_[0]) + numbers_.bytes();
}

}  // namespace foreland::server
