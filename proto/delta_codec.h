// Cut deltas as bytes: which nodes go, which come, and the height of each that comes.
//
// Slots are coded as gaps, heights as what is left after predicting the mean of the node's edge endpoints, all as varints
// (LEB128, signed values zigzag). A vertex's endpoints lie on coarser levels, hence before it, so the decoder always knows them.
// Every count is bounded by the bytes that are there before anything is allocated; any byte string ends in a delta or an
// Error. Closure is the receiver's to check (client/replica.h), for only it knows the section.
// Pure functions; any thread; O(nodes in the delta).
#pragma once

#include <concepts>
#include <vector>

#include "base/bytes.h"
#include "proto/section.h"

namespace foreland::proto {

// Largest quantised height, steps either way: heights and their sums stay far inside int32.
inline constexpr int32_t kMaxHeight = 1 << 29;

struct HeightDelta {
  CutDelta cut;
  std::vector<int32_t> heights;  // of cut.added, in steps
};

// Height of any vertex by id, or nothing if the caller does not hold it.
template <class F>
concept HeightSource = requires(F f, NodeId v) {
  { f(v) } -> std::convertible_to<int32_t>;
};

namespace codec_detail {

inline int32_t predicted(int32_t a, int32_t b) { return (a + b) >> 1; }

void putSlots(const std::vector<Slot>& slots, ByteWriter& writer);
Status getSlots(const GridTopology& grid, ByteReader& reader, std::vector<Slot>& slots);

}  // namespace codec_detail

// Appends the delta to `out`. `height_of` knows every vertex involved.
template <HeightSource F>
void encodeDelta(const GridTopology& grid, const CutDelta& cut, F&& height_of, Bytes& out) {
  ByteWriter writer(out);
  codec_detail::putSlots(cut.removed, writer);
  codec_detail::putSlots(cut.added, writer);
  for (Slot slot : cut.added) {
    const NodeId n = grid.node(slot);
    const auto [a, b] = grid.endpoints(n);
    writer.putZigzag(int64_t{height_of(n)} - codec_detail::predicted(height_of(a), height_of(b)));
  }
}

// Reads a delta to the end of `bytes`. `known_height(v)` gives the height of a vertex the receiver holds, or nullptr. On an
// Error `out` is unspecified and the receiver's state untouched.
template <class F>
Status decodeDelta(const GridTopology& grid, ByteSpan bytes, F&& known_height, HeightDelta& out) {
  const auto malformed = [](const char* what) { return Error{ErrorCode::kMalformed, std::string("cut delta: ") + what}; };
  ByteReader reader(bytes);
  if (Status s = codec_detail::getSlots(grid, reader, out.cut.removed); !s.ok()) return s;
  if (Status s = codec_detail::getSlots(grid, reader, out.cut.added); !s.ok()) return s;
  const auto& added = out.cut.added;
  out.heights.clear();
  out.heights.reserve(added.size());
  const auto height_of = [&](NodeId v) -> const int32_t* {
    if (const int32_t* known = known_height(v)) return known;
    if (grid.isBase(v)) return nullptr;
    const Slot slot = grid.slot(v);
    const auto end = added.begin() + static_cast<ptrdiff_t>(out.heights.size());
    const auto it = std::lower_bound(added.begin(), end, slot);
    return it != end && *it == slot ? &out.heights[static_cast<size_t>(it - added.begin())] : nullptr;
  };
  for (Slot slot : added) {
    const auto [a, b] = grid.endpoints(grid.node(slot));
    const int32_t *height_a = height_of(a), *height_b = height_of(b);
    if (!height_a || !height_b) return malformed("a node comes before the edge that it refines");
    const int64_t height = codec_detail::predicted(*height_a, *height_b) + reader.getZigzag();
    if (!reader.ok() || height < -kMaxHeight || height > kMaxHeight) return malformed("a height is missing or absurd");
    out.heights.push_back(static_cast<int32_t>(height));
  }
  if (!reader.atEnd()) return malformed("bytes left over");
  return {};
}

}  // namespace foreland::proto
