// Cut deltas as bytes: which nodes go, which come, and the height of each that comes, by adaptive range coding.
//
// The changes are found from the roots down a quadtree of cells: a cell of 2s holds its centre node and the side nodes
// on its south and west borders. "Does anything change in here?" is one bit; so the cost follows the changes, not the
// section. A node can come only if its parents are there, and goes untold when a parent goes; what is told costs what
// its context makes of it: the view before and after (both ends have them), the level, the nodes around.
// docs/decisions/wire_codec.md has the measurements.
//
// The model keeps what it has learnt from delta to delta; both ends begin with a new one wherever a delta starts from a
// section that was presented (or from nothing). Any bytes end in a delta that fits the held section, or in an Error, in
// time and memory linear in the bytes and the section held. One owner of a model; otherwise pure; any thread. Portable
// to WebAssembly.
#pragma once

#include <array>
#include <vector>

#include "base/bytes.h"
#include "base/result.h"
#include "proto/frame_grid.h"
#include "proto/message.h"
#include "proto/range_coder.h"
#include "proto/section.h"

namespace foreland::proto {

// Largest quantised height, steps either way: heights and their sums stay far inside int32.
inline constexpr int32_t kMaxHeight = 1 << 29;
// Nodes that one delta may add: no more than these, and no more than these for each of its bytes (the least probability
// sees to that).
inline constexpr size_t kMaxDeltaNodes = 1u << 22;
inline constexpr size_t kNodesPerByte = 128;

struct HeightDelta {
  CutDelta cut;
  std::vector<int32_t> heights;  // of cut.added, in steps
};

// What a section is for, as the keyframe's header has it.
struct DeltaView {
  Pose pose;
  double tau_px = 1, ball_m = 0, turn_rad = 0;
};
// Of a header as received. A header about to be sent goes through asSent first: rounding a pose twice may round it
// further.
inline DeltaView viewOf(const KeyframeHeader& h) { return {h.pose, h.tau_px, h.ball_m, h.turn_rad}; }
inline DeltaView viewAsSent(const KeyframeHeader& h) { return {asSent(h.pose), h.tau_px, h.ball_m, h.turn_rad}; }

// The nodes of a section. The encoder's is the section that results, the decoder's the one that it holds.
class HeldNodes {
 public:
  virtual ~HeldNodes() = default;
  virtual bool has(Slot slot) const = 0;
  // In steps, of a base vertex or a node of the section. The encoder's knows all nodes.
  virtual int32_t height(NodeId v) const = 0;
};

// What both ends have learnt, and the view of the previous delta.
struct DeltaModel {
  static constexpr int kShrink = 8, kSides = 8, kNear = 8, kMagnitudes = 24;

  std::array<AdaptiveBit, 4 * kSides * 4 * kShrink * 4> alive;
  std::array<AdaptiveBit, 2 * 3 * kSides * 4> goes;
  std::array<AdaptiveBit, 2 * 16 * kSides * 8> comes;             // next to nodes that just came
  std::array<AdaptiveBit, 2 * kShrink * 4 * 16 * 4> comes_later;  // could have come before
  std::array<std::array<AdaptiveBit, 16>, kMagnitudes * 3> exponent;
  std::array<AdaptiveBit, 64> escape;
  std::array<AdaptiveBit, 12> sign;
  std::array<std::array<AdaptiveBit, 4>, 32> mantissa;
  AdaptiveBit border;
  AdaptiveBit unit_changes, off_unit;
  uint32_t unit = 1;  // heights are multiples of it
  bool has_view = false;
  DeltaView view;
};

// Where an encoder's bits went.
struct DeltaBits {
  double structure = 0, heights = 0;
};

// Appends the delta, which leads to `held`, to `out`. The delta is sorted and closed (settle); `view` is as the
// receiver has it.
void encodeDelta(const GridTopology& grid, const FrameGrid& frame, const CutDelta& cut, const DeltaView& view,
                 const HeldNodes& held, DeltaModel& model, Bytes& out, DeltaBits* bits = nullptr);

// Reads a delta from `held` to the end of `bytes`. On an Error `out` and `model` are unspecified.
Status decodeDelta(const GridTopology& grid, const FrameGrid& frame, ByteSpan bytes, const DeltaView& view,
                   const HeldNodes& held, DeltaModel& model, HeightDelta& out);

}  // namespace foreland::proto
