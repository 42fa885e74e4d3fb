// What both ends know of a node's bounds, in few bits: a quantised error and a quantised radius. Bounds are rounded
// up, so they never understate; being coarse they cost little to send, and both ends can run the
// same refinement test on them (so removals cost nothing on the wire). Immutable values; any thread; portable.
#pragma once

#include <array>
#include <bit>
#include <compare>
#include <cstdint>

#include "proto/space/frame.h"
#include "proto/topology/grid.h"

namespace foreland::proto {

namespace bounds_detail {

// 2^(i/8), rounded up.
inline constexpr std::array<float, 8> kEighths{1.0f,        1.09050775f, 1.1892072f,  1.29683959f,
                                               1.41421366f, 1.54221094f, 1.68179286f, 1.8340081f};

constexpr float power(int eighths) {
  const int octave = (eighths < 0 ? eighths - 7 : eighths) / 8;
  return std::bit_cast<float>(static_cast<uint32_t>(127 + octave) << 23) *
         kEighths[static_cast<size_t>(eighths - 8 * octave)];
}

// The least i with x <= power(i), for a positive normal x.
inline int eighthsAbove(float x) {
  const uint32_t bits = std::bit_cast<uint32_t>(x), mantissa = bits & 0x7fffff;
  int above = 8 * (static_cast<int>(bits >> 23) - 127);
  for (const float step : kEighths) above += mantissa > (std::bit_cast<uint32_t>(step) & 0x7fffff) ? 1 : 0;
  return above;
}

// The least float that is not below x.
inline float floatAbove(double x) {
  const float nearest = static_cast<float>(x);
  return std::bit_cast<float>(std::bit_cast<uint32_t>(nearest) + (nearest < x ? 1 : 0));
}

}  // namespace bounds_detail

// An error in metres: 0, or a power of 2^(1/2) between 2^-24 and 2^103.
struct QuantisedError {
  static constexpr int kPerOctave = 2, kZero = 24 * kPerOctave + 1;  // the value of one metre

  uint8_t value = 0;

  float metres() const { return table()[value]; }
  // `metres` is not negative and below 2^38.
  static QuantisedError roundUp(double metres) {
    if (metres <= 0) return {};
    constexpr int kEach = 8 / kPerOctave;
    const int eighths = bounds_detail::eighthsAbove(bounds_detail::floatAbove(metres)) + 8 * 24;
    return {static_cast<uint8_t>(eighths < 0 ? 1 : (eighths + kEach - 1) / kEach + 1)};
  }
  // The same as roundUp() and metres() for errors from 2^-24 to 2^100 and values above 0, in few operations on bits:
  // for loops that become vector instructions.
  static int32_t roundUpFast(float metres) {
    static_assert(kPerOctave == 2);
    const int32_t bits = std::bit_cast<int32_t>(metres), mantissa = bits & 0x7fffff;
    return 2 * ((bits >> 23) - 127) + (mantissa > 0 ? 1 : 0) + (mantissa > kHalfOctave ? 1 : 0) + kZero;
  }
  static float metresFast(int32_t value) {
    const int32_t halves = value - kZero + 2 * 127;
    return std::bit_cast<float>((halves >> 1 << 23) + (halves & 1) * kHalfOctave);
  }
  auto operator<=>(const QuantisedError&) const = default;

 private:
  // The mantissa of 2^(1/2), rounded up.
  static constexpr int32_t kHalfOctave = std::bit_cast<int32_t>(bounds_detail::kEighths[4]) & 0x7fffff;

  static const std::array<float, 256>& table() {
    static constexpr std::array<float, 256> kTable = [] {
      std::array<float, 256> t{};
      for (int i = 1; i < 256; ++i) t[static_cast<size_t>(i)] = bounds_detail::power((i - kZero) * (8 / kPerOctave));
      return t;
    }();
    return kTable;
  }
};

// A sphere's radius as a multiple of what it would be on level ground: 2^(value/4). Level ground nests exactly, and so
// does any even slope, so rounding up does not add up from level to level.
struct QuantisedRadius {
  static constexpr int kMax = 127;

  uint8_t value = 0;
  float factor() const { return table()[value]; }
  auto operator<=>(const QuantisedRadius&) const = default;

 private:
  // Of any byte: a damaged file may hold more than kMax.
  static const std::array<float, 256>& table() {
    static constexpr std::array<float, 256> kTable = [] {
      std::array<float, 256> t{};
      for (int i = 0; i < 256; ++i) t[static_cast<size_t>(i)] = bounds_detail::power(2 * (i < kMax ? i : kMax));
      return t;
    }();
    return kTable;
  }
};

// Largest height, quanta either way: heights and displacements fit a record, and their sums stay far inside int32.
inline constexpr int32_t kMaxHeight = (1 << 22) - 1;

// What is known of one node, at its slot. Heights are in quanta of Frame::height_quantum_m above the zero surface.
//   error   saturated: largest distance (m) between the true surface and the surface without this node or any of its
//           descendants, over this node's support; 0 beyond the data
//   radius  saturated: sphere about the middle of the node's edge (SphereLevels) that holds its support and its
//           children's spheres; the same for all nodes of a page (kPageSlots)
struct NodeRecord {
  uint64_t bits = 0;  // from the lowest: height (24), displacement (24), error (8), radius (8)

  static NodeRecord of(int32_t height, int32_t displacement, QuantisedError error, QuantisedRadius radius) {
    return {(static_cast<uint64_t>(static_cast<uint32_t>(height)) & 0xffffff) |
            (static_cast<uint64_t>(static_cast<uint32_t>(displacement)) & 0xffffff) << 24 |
            static_cast<uint64_t>(error.value) << 48 | static_cast<uint64_t>(radius.value) << 56};
  }
  int32_t height() const { return static_cast<int32_t>(static_cast<int64_t>(bits << 40) >> 40); }
  // The height minus that of the middle of the node's edge.
  int32_t displacement() const { return static_cast<int32_t>(static_cast<int64_t>(bits << 16) >> 40); }
  int32_t middle() const { return height() - displacement(); }
  QuantisedError error() const { return {static_cast<uint8_t>(bits >> 48)}; }
  QuantisedRadius radius() const { return {static_cast<uint8_t>(bits >> 56)}; }

  // A client's record, of which a page's radius stands elsewhere, has in place of the radius how the sum of the heights
  // of the edge's ends is rounded to their middle, so that the ends need not be looked up again. This one is of a node
  // that is not known yet.
  static NodeRecord ofEnds(int32_t a, int32_t b) {
    return of(static_cast<int32_t>((int64_t{a} + b) >> 1), 0, {}, {static_cast<uint8_t>(kHasEnds | ((a ^ b) & 1))});
  }
  // The same edge's node, once its height is known, or its error.
  NodeRecord withHeight(int32_t height) const { return of(height, height - middle(), {}, radius()); }
  NodeRecord withError(QuantisedError error) const { return of(height(), displacement(), error, radius()); }
  // Whether ends() may be asked for. Records of scenes say no.
  bool hasEnds() const { return radius().value >= kHasEnds; }
  // The sum of the heights of the edge's ends.
  int32_t ends() const { return 2 * middle() + (radius().value & 1); }

  bool operator==(const NodeRecord&) const = default;

 private:
  static constexpr uint8_t kHasEnds = QuantisedRadius::kMax + 1;
};
static_assert(sizeof(NodeRecord) == 8);

// The middle of an edge, quanta.
inline int32_t middleOf(int32_t a, int32_t b) { return static_cast<int32_t>((int64_t{a} + b) >> 1); }

// Level by level, the spheres of level ground. A node's sphere is about its lattice position at the height of the
// middle of its edge, which a client knows before it knows the node.
class SphereLevels {
 public:
  SphereLevels(const GridTopology& grid, const Frame& frame);

  float radius(int level, QuantisedRadius c) const { return flat_m_[static_cast<size_t>(level)] * c.factor(); }
  // The least quantised radius whose sphere is not smaller.
  QuantisedRadius roundUp(int level, double radius_m) const;

 private:
  std::array<float, GridTopology::kMaxLevels + 1> flat_m_{};
};

}  // namespace foreland::proto
