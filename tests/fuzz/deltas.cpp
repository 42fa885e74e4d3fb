// Any bytes as cut deltas one after the other, from nothing or from a presented section: each leads to a closed
// section, or is an Error. First byte: where to start and where the camera goes; two bytes of
// length stand before each delta.
#include "base/check.h"
#include "proto/delta_codec.h"
#include "tests/support/toy_terrain.h"

namespace foreland::proto {
namespace {

View viewAt(uint8_t how, int step) {
  View view;
  view.pose = {{160.0 + 7 * step, 100.0 + how, 250.0 + 3 * how}, lookAlong({0.5, 0.3, -0.8}, {0, 0, 1})};
  view.tau_px = 1 + (how >> 6);
  view.ball_m = step;
  return view;
}

void run(ByteSpan bytes) {
  static const test::ToyTerrain terrain({2, 2, 4, 33, 30}, 1);
  if (bytes.empty()) return;
  const uint8_t how = bytes[0];
  bytes = bytes.subspan(1);
  SparseNodes nodes(terrain.grid(), terrain.base());
  TerrainAdapter adapter(terrain.domain());
  if (how & 1) {
    const Section section = terrain.refine(viewAt(how, 2));
    PlainNodes source(terrain.nodes());
    adapter = TerrainAdapter(terrain.domain(), section.slots, source);
    for (Slot slot : section.slots) nodes.make(slot) = terrain.nodes()[slot];
  }
  DeltaModel model;
  for (int step = 0; step < 4 && bytes.size() >= 2; ++step) {
    const size_t size = std::min<size_t>(bytes[0] | bytes[1] << 8, bytes.size() - 2);
    CutDelta delta;
    AdaptScratch scratch;
    DeltaDecoder decoder(terrain.domain(), nodes, model, bytes.subspan(2, size));
    const bool done = adapter.adapt(viewAt(how, step), kMaxSectionNodes, decoder, scratch, delta);
    CHECK_TRUE(validate(terrain.grid(), adapter.section()).ok());
    if (!done || !decoder.finish().ok()) return;
    adapter.validate();
    bytes = bytes.subspan(2 + size);
  }
}

}  // namespace
}  // namespace foreland::proto

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  foreland::proto::run({data, size});
  return 0;
}
