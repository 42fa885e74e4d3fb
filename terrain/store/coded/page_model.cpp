#include "terrain/store/coded/page_model.h"

#include <algorithm>
#include <cmath>

namespace foreland::terrain {

namespace {

// 16384 / 2^(i / 4), in numbers that are the same on every machine.
constexpr std::array<uint16_t, 28> kRarer = [] {
  constexpr std::array<uint32_t, 4> kQuarters{1073741824, 902905651, 759250125, 638450708};  // of 2^30
  std::array<uint16_t, 28> rarer{};
  for (size_t i = 0; i < rarer.size(); ++i) {
    const size_t shift = 16 + i / 4;
    rarer[i] = static_cast<uint16_t>((kQuarters[i % 4] + (1u << (shift - 1))) >> shift);
  }
  return rarer;
}();

// Codes a start; the same code reads and writes.
template <class Coder>
void codeSteps(Coder& coder, std::span<uint8_t> steps) {
  std::array<proto::AdaptiveBit, 4> is_even;
  std::array<proto::AdaptiveBit, 64> step;
  proto::EscapeModel escape;
  proto::Symbols<Coder> symbols(coder, escape);
  size_t before = 0;  // whether the last two were even
  for (uint8_t& s : steps) {
    const bool even = coder.code(is_even[before], s == 0);
    before = (2 * before + (even ? 1 : 0)) & 3;
    s = even ? 0 : static_cast<uint8_t>(symbols.template tree<6>(step, s));
  }
}

}  // namespace

uint16_t ModelStart::probability(uint8_t step) {
  const uint16_t rarer = kRarer[std::min<size_t>(step % kSteps, kRarer.size() - 1)];
  return step < kSteps ? rarer : static_cast<uint16_t>(32768 - rarer);
}

void ModelStart::set(size_t context, uint64_t no, uint64_t yes) {
  steps_[context] = 0;
  if (no + yes < 2) return;
  const uint64_t rare = std::min(no, yes);
  const double p = 32768 * (static_cast<double>(rare) + 0.4) / (static_cast<double>(no + yes) + 0.8);
  uint8_t step = 0;
  while (step + 1 < kSteps && kRarer[step + 1u] > p) ++step;
  steps_[context] = static_cast<uint8_t>(yes <= no ? step : step == 0 ? 0 : kSteps + step);
}

void ModelStart::apply(PageModel& model) const {
  const std::span<proto::AdaptiveBit> contexts = model.contexts();
  for (size_t i = 0; i < kPageContexts; ++i) {
    const uint16_t p = probability(steps_[i]);
    contexts[i] = {p, p};
  }
}

Bytes ModelStart::encode() const {
  Bytes bytes;
  proto::RangeEncoder coder(bytes);
  auto steps = steps_;
  codeSteps(coder, steps);
  coder.finish();
  return bytes;
}

bool ModelStart::decode(ByteSpan bytes) {
  proto::RangeDecoder coder(bytes);
  steps_ = {};
  codeSteps(coder, steps_);
  return coder.atEnd() && std::ranges::all_of(steps_, [](uint8_t s) { return s < 2 * kSteps; });
}

}  // namespace foreland::terrain
