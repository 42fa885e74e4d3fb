#include "proto/codec/epoch_stream.h"

#include <algorithm>
#include <bit>
#include <cstdlib>

#include "base/sort.h"

namespace foreland::proto {

namespace {

size_t widthOf(int64_t x) { return static_cast<size_t>(std::bit_width(static_cast<uint64_t>(std::abs(x)))); }

// Whether more was read than there is.
bool isOver(const RangeEncoder&) { return false; }
bool isOver(const RangeDecoder& coder) { return coder.overrun(); }

}  // namespace

void EpochStream::restart() {
  offsets_.clear();
  restartCoder();
}

void EpochStream::resume() {
  offsets_.forget();
  restartCoder();
}

void EpochStream::restartCoder() {
  model_ = {};
  scene_time_ = {};
  step_ = {};
  is_first_ = true;
  blended_ = {};
}

// A keyframe's time continues the last step, or is said in 64 bits.
template <class Coder>
Time EpochStream::codeTime(Coder& coder, Time scene_time) {
  const Time expected = scene_time_ + step_;
  if (coder.code(model_.time[0], scene_time == expected)) return expected;
  if (coder.code(model_.time[1], scene_time == scene_time_)) return scene_time_;
  uint64_t bits = 0;
  for (int shift = 48; shift >= 0; shift -= 16)
    bits = bits << 16 |
           coder.codeEvenly(static_cast<uint32_t>(static_cast<uint64_t>(scene_time.us) >> shift & 0xffff), 16);
  return {static_cast<int64_t>(bits)};
}

template <class Coder, class ValueOf>
bool EpochStream::codeEpoch(uint32_t epoch, std::span<const Slot> slots, Coder& coder, const ValueOf& valueOf) {
  Symbols<Coder> symbols(coder, model_.escape);
  size_t before = 0;
  for (Slot slot : slots) {
    const NodeId n = grid_->node(slot);
    if (offsets_.knows(epoch, n)) continue;
    const uint32_t known = offsets_.nearestKnown(epoch, n);
    const auto [a, b] = grid_->endpoints(n);
    const int64_t at_a = int64_t{offsets_.known(epoch, a)} - offsets_.known(known, a),
                  at_b = int64_t{offsets_.known(epoch, b)} - offsets_.known(known, b);
    const int64_t guess = offsets_.known(known, n) + ((at_a + at_b) >> 1);
    const size_t activity =
        std::min(std::max(widthOf(at_a), widthOf(at_b)) + (at_a == at_b ? 0 : 1), Model::kActivities - 1);
    const size_t sign = at_a + at_b == 0 ? 0 : at_a + at_b < 0 ? 1 : 2;
    const int32_t difference = symbols.number(model_.offset[activity * Model::kBefore + before], sign,
                                              static_cast<int32_t>(valueOf(epoch, slot) - guess));
    const int64_t value = guess + difference;
    if (std::abs(value) > kMaxOffset || isOver(coder)) return false;
    offsets_.set(epoch, n, static_cast<int32_t>(value));
    before = std::min(widthOf(difference), Model::kBefore - 1);
    ++coded_;
  }
  return true;
}

void EpochStream::forget(const EpochWeights& next) {
  if (offsets_.blockCount() <= kMaxBlocks) return;
  const auto isBlended = [&](uint32_t epoch) {
    const auto has = [epoch](const EpochWeights& w) {
      return std::ranges::find(w.epochs(), epoch) != w.epochs().end();
    };
    return has(blended_) || has(next);
  };
  for (uint32_t epoch = 0; epoch < offsets_.epochs().size(); ++epoch)
    if (!isBlended(epoch)) offsets_.clear(epoch);
}

template <class Coder, class ValueOf>
bool EpochStream::code(Time wanted, bool is_step, const TerrainAdapter& adapter, std::span<const Slot> added,
                       Coder& coder, const ValueOf& valueOf) {
  const Epochs& epochs = offsets_.epochs();
  const Time scene_time = codeTime(coder, wanted);
  if (scene_time < epochs.first() || scene_time > epochs.last()) return false;
  is_step_ = epochs.blend() != EpochBlend::kLinear && coder.code(model_.is_step, is_step);
  const EpochWeights next = epochs.weightsAt(scene_time);
  const bool has_same = !is_first_ && std::ranges::equal(next.epochs(), blended_.epochs());
  if (has_same) {
    slots_.assign(added.begin(), added.end());
    foreland::sort(slots_.begin(), slots_.end());
  } else {
    forget(next);
    slots_ = adapter.section().slots;
  }
  for (uint32_t epoch : next.epochs())
    if (!codeEpoch(epoch, slots_, coder, valueOf)) return false;
  step_ = is_first_ ? Duration{} : scene_time - scene_time_;
  scene_time_ = scene_time;
  blended_ = next;
  is_first_ = false;
  return true;
}

void EpochStream::encode(Time scene_time, bool is_step, const TerrainAdapter& adapter, std::span<const Slot> added,
                         const OffsetSource& source, RangeEncoder& coder, EpochBits& bits) {
  const double before = coder.bits();
  const uint64_t coded = coded_;
  CHECK_TRUE(code(scene_time, is_step, adapter, added, coder,
                  [&](uint32_t epoch, Slot slot) { return int64_t{source.offset(epoch, slot)}; }));
  bits = {coder.bits() - before, coded_ - coded};
}

bool EpochStream::decode(const TerrainAdapter& adapter, std::span<const Slot> added, RangeDecoder& coder) {
  return code({}, false, adapter, added, coder, [](uint32_t, Slot) { return int64_t{0}; });
}

}  // namespace foreland::proto
