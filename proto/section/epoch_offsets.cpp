#include "proto/section/epoch_offsets.h"

#include <algorithm>
#include <tuple>

namespace foreland::proto {

namespace {

bool isBefore(const BaseOffset& a, const BaseOffset& b) {
  return std::tie(a.epoch, a.vertex) < std::tie(b.epoch, b.vertex);
}

}  // namespace

EpochOffsets::EpochOffsets(const GridTopology& grid, Epochs epochs, std::span<const BaseOffset> base)
    : grid_(&grid), epochs_(std::move(epochs)), base_(base.begin(), base.end()), tables_(epochs_.size()) {
  std::sort(base_.begin(), base_.end(), isBefore);
}

const EpochOffsets::Block& EpochOffsets::block(uint32_t epoch, Slot slot) const {
  const Table& table = tables_[epoch];
  return table.blocks[table.numbers.find(slot / kBlockSlots)];
}

bool EpochOffsets::knows(uint32_t epoch, NodeId n) const {
  if (!epochs_.mayMove(epoch, n)) return true;
  const Slot slot = grid_->slot(n);
  return block(epoch, slot).known >> (slot % kBlockSlots) & 1;
}

uint32_t EpochOffsets::nearestKnown(uint32_t epoch, NodeId n) const {
  for (uint32_t distance = 0; distance < tables_.size(); ++distance) {
    if (distance <= epoch && knows(epoch - distance, n)) return epoch - distance;
    if (epoch + distance < tables_.size() && knows(epoch + distance, n)) return epoch + distance;
  }
  return 0;
}

int32_t EpochOffsets::baseAt(uint32_t epoch, NodeId v) const {
  const BaseOffset wanted{epoch, baseVertexNumber(*grid_, v), 0};
  const auto at = std::lower_bound(base_.begin(), base_.end(), wanted, isBefore);
  return at != base_.end() && at->epoch == epoch && at->vertex == wanted.vertex ? at->quanta : 0;
}

std::optional<int32_t> EpochOffsets::find(uint32_t epoch, NodeId v, Bits bits) const {
  if (!epochs_.mayMove(epoch, v)) return 0;
  if (grid_->isBase(v)) return baseAt(epoch, v);
  const Slot slot = grid_->slot(v);
  const Block& found = block(epoch, slot);
  if (!(found.*bits >> (slot % kBlockSlots) & 1)) return std::nullopt;
  return found.quanta[slot % kBlockSlots];
}

int32_t EpochOffsets::nearest(uint32_t epoch, NodeId v, Bits bits) const {
  for (uint32_t distance = 0; distance < tables_.size(); ++distance) {
    if (distance <= epoch)
      if (const auto quanta = find(epoch - distance, v, bits)) return *quanta;
    if (epoch + distance < tables_.size())
      if (const auto quanta = find(epoch + distance, v, bits)) return *quanta;
  }
  return 0;
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
