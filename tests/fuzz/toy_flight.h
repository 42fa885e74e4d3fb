// What the fuzzers of deltas share with the recorder of their corpora: the terrain, the views, and the layout of an
// input. An input is a byte that selects the flight (for terrain, its lowest bit says whether the flight begins with a
// section that the client resumes from, the next two how much the client remembers), then up to kToySteps deltas, each
// after its size in two bytes, little-endian. The camera looks elsewhere and back, so that what was left comes again.
#pragma once

#include <algorithm>
#include <array>

#include "base/bytes.h"
#include "proto/space/pose.h"
#include "tests/support/toy_terrain.h"

namespace foreland::test {

inline constexpr int kToySteps = 6;

inline void appendToyDelta(const Bytes& delta, Bytes& input) {
  input.push_back(static_cast<uint8_t>(delta.size() & 255));
  input.push_back(static_cast<uint8_t>(delta.size() >> 8));
  input.insert(input.end(), delta.begin(), delta.end());
}

// Calls take(step, delta) for each that an input has behind its first byte, cut short if it ends there, until one is
// refused. A delta lies where a sanitizer sees each byte read beyond it.
template <class Take>
void forEachToyDelta(ByteSpan deltas, const Take& take) {
  for (int step = 0; step < kToySteps && deltas.size() >= 2; ++step) {
    const size_t size = std::min<size_t>(deltas[0] | deltas[1] << 8, deltas.size() - 2);
    const Bytes exact(deltas.begin() + 2, deltas.begin() + 2 + static_cast<ptrdiff_t>(size));
    if (!take(step, exact)) return;
    deltas = deltas.subspan(2 + size);
  }
}

inline const ToyTerrain& toyFlightTerrain() {
  static const ToyTerrain terrain({2, 2, 4, 33, 30}, 1);
  return terrain;
}

inline proto::View toyFlightView(uint8_t how, int step) {
  proto::View view;
  const double side = step % 3 == 1 ? -1 : 1;
  view.pose = {{160.0 + 7 * step, 100.0 + how, 250.0 + 3 * how},
               proto::lookAlong({0.5 * side, 0.3 * side, -0.8}, {0, 0, 1})};
  view.tau_px = static_cast<float>(1 + (how >> 6));
  view.region_radius_m = static_cast<float>(step);
  return view;
}

// Nothing, one page, a few, all.
inline uint64_t toyFlightMemory(uint8_t how) { return std::array<uint64_t, 4>{0, 700, 2600, 1 << 20}[how >> 1 & 3]; }

// The section that a flight begins with: empty, or the one that the client resumes from.
inline proto::Section toyFlightBegin(uint8_t how) {
  return how & 1 ? toyFlightTerrain().refine(toyFlightView(how, 2)) : proto::Section();
}

}  // namespace foreland::test
