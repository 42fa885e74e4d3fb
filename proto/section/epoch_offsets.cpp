#include "proto/section/epoch_offsets.h"

namespace foreland::proto {

EpochOffsets::EpochOffsets(const GridTopology& grid, Epochs epochs, std::span<const BaseOffset> base)
    : grid_(&grid), epochs_(std::move(epochs)), base_(base.begin(), base.end()), tables_(epochs_.size()) {
  sortBaseOffsets(base_);
}

const EpochOffsets::Block& EpochOffsets::block(uint32_t epoch, Slot slot) const {
  const Table& table = tables_[epoch];
  return table.blocks[table.numbers.find(slot / kBlockSlots)];
}

std::optional<int32_t> EpochOffsets::find(uint32_t epoch, NodeId v, Bits bits) const {
  if (!epochs_.mayMove(epoch, v)) return 0;
  if (grid_->isBase(v)) return baseOffsetAt(base_, epoch, baseVertexNumber(*grid_, v));
  const Slot slot = grid_->slot(v);
  const Block& found = block(epoch, slot);
  if (!(found.*bits >> (slot % kBlockSlots) & 1)) return std::nullopt;
  return found.quanta[slot % kBlockSlots];
}

EpochOffsets::Found EpochOffsets::nearest(uint32_t epoch, NodeId v, Bits bits) const {
  for (uint32_t distance = 0; distance < tables_.size(); ++distance) {
    if (distance <= epoch)
      if (const auto quanta = find(epoch - distance, v, bits)) return {epoch - distance, *quanta};
    if (epoch + distance < tables_.size())
      if (const auto quanta = find(epoch + distance, v, bits)) return {epoch + distance, *quanta};
  }
  return {};
}

double EpochOffsets::at(const EpochWeights& weights, NodeId v) const {
  double sum = 0;
  for (uint32_t i = 0; i < weights.count; ++i) sum += weights.weight[i] * at(weights.epoch[i], v);
  return sum;
}

void EpochOffsets::set(uint32_t epoch, NodeId n, int32_t quanta) {
  const Slot slot = grid_->slot(n);
  Table& table = tables_[epoch];
  uint32_t number = table.numbers.find(slot / kBlockSlots);
  if (number == IndexTable::kNone) {
    number = static_cast<uint32_t>(table.blocks.size());
    table.blocks.emplace_back();
    table.numbers.insert(slot / kBlockSlots, number);
  }
  Block& block = table.blocks[number];
  block.known |= uint64_t{1} << (slot % kBlockSlots);
  block.held |= block.known;
  block.quanta[slot % kBlockSlots] = quanta;
}

void EpochOffsets::forget() {
  for (Table& table : tables_)
    for (Block& block : table.blocks) block.known = 0;
}

void EpochOffsets::clear() {
  for (uint32_t epoch = 0; epoch < tables_.size(); ++epoch) clear(epoch);
}

void EpochOffsets::clear(uint32_t epoch) { tables_[epoch] = {}; }

size_t EpochOffsets::blockCount() const {
  size_t count = 0;
  for (const Table& table : tables_) count += table.blocks.size() - 1;
  return count;
}

}  // namespace foreland::proto
