// Any bytes as two cut deltas one after the other: each leads to a closed section that is not larger than its bytes
// allow, or is an Error. First byte: the section to start from, and how the rest is shared among the deltas.
#include <algorithm>

#include "base/check.h"
#include "proto/delta_codec.h"

namespace foreland::proto {
namespace {

class Nodes final : public HeldNodes {
 public:
  Nodes(const GridTopology& grid, const Section& section) : grid_(grid), section_(section) {}
  bool has(Slot slot) const override { return std::binary_search(section_.slots.begin(), section_.slots.end(), slot); }
  int32_t height(NodeId v) const override {
    CHECK_TRUE(grid_.isBase(v) || has(grid_.slot(v)));  // nothing else may be asked for
    return static_cast<int32_t>(fingerprint(v.x() * 1009 + v.y()) % 60000) - 30000;
  }

 private:
  const GridTopology& grid_;
  const Section& section_;
};

// All nodes down to a level.
Section coarse(const GridTopology& grid, int level) {
  Section section;
  for (Slot slot = 0; slot < grid.levelOffset(level + 1); ++slot)
    if (!grid.isBase(grid.node(slot))) section.slots.push_back(slot);
  return section;
}

void run(ByteSpan bytes) {
  static const GridTopology grid = *GridTopology::create({2, 2, 4, 33, 30});
  static const FrameGrid frame(Frame{}, grid.maxX(), grid.maxY());
  if (bytes.empty()) return;
  const uint8_t how = bytes[0];
  bytes = bytes.subspan(1);
  Section held = how & 1 ? coarse(grid, 1 + (how >> 1) % 6) : Section{};
  DeltaModel model;
  const size_t first = bytes.size() * (how >> 4) / 15;
  for (const ByteSpan part : {bytes.first(first), bytes.subspan(first)}) {
    HeightDelta delta;
    const DeltaView view{.pose = {.eye = {how * 0.1, 20, 5}}};
    if (!decodeDelta(grid, frame, part, view, Nodes(grid, held), model, delta).ok()) return;
    CHECK_EQ(delta.heights.size(), delta.cut.added.size());
    CHECK_LE(delta.cut.added.size(), kNodesPerByte * (part.size() + 1));
    held = apply(held, delta.cut);
    CHECK_TRUE(validate(grid, held).ok());
  }
}

}  // namespace
}  // namespace foreland::proto

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  foreland::proto::run({data, size});
  return 0;
}
