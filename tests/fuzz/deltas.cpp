// Takes any bytes as consecutive cut deltas, from an empty section or one that is resumed from
// (tests/fuzz/toy_flight.h). Each one must lead to a closed section or to an Error.
#include "base/check.h"
#include "proto/codec/delta_codec.h"
#include "tests/fuzz/toy_flight.h"

namespace foreland::proto {
namespace {

// What a client of each of the 256 flights holds at first; made once.
struct Begin {
  SparseNodes nodes;
  TerrainAdapter adapter;
};

const Begin& beginOf(uint8_t how) {
  static std::vector<std::optional<Begin>> begins(256);
  std::optional<Begin>& begin = begins[how];
  if (begin) return *begin;
  const test::ToyTerrain& terrain = test::toyFlightTerrain();
  const Section section = test::toyFlightBegin(how);
  begin.emplace(Begin{SparseNodes(terrain.grid(), terrain.base()), TerrainAdapter(terrain.domain())});
  begin->adapter.memory().pages.setBudget(test::toyFlightMemory(how));
  if (section.slots.empty()) return *begin;
  InMemoryNodes source(terrain.nodes());
  begin->adapter = TerrainAdapter(terrain.domain(), section.slots, source);
  begin->adapter.memory().pages.setBudget(test::toyFlightMemory(how));
  for (Slot slot : section.slots) begin->nodes.make(slot) = terrain.nodes()[slot];
  return *begin;
}

void run(ByteSpan bytes) {
  static AdaptScratch scratch;
  CutDelta delta;
  const test::ToyTerrain& terrain = test::toyFlightTerrain();
  if (bytes.empty()) return;
  const uint8_t how = bytes[0];
  Begin held = beginOf(how);
  DeltaModel model;
  test::forEachToyDelta(bytes.subspan(1), [&](int step, ByteSpan exact) {
    DeltaDecoder decoder(terrain.domain(), held.nodes, model, exact);
    const bool done = held.adapter.adapt(test::toyFlightView(how, step), kMaxSectionNodes, decoder, scratch, delta);
    CHECK_TRUE(validate(terrain.grid(), held.adapter.section()).ok());
    if (!done || !decoder.finish().ok()) return false;
    held.adapter.validate();
    CHECK_LE(held.adapter.memory().pages.clientBytes(), test::toyFlightMemory(how));
    return true;
  });
}

}  // namespace
}  // namespace foreland::proto

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  foreland::proto::run({data, size});
  return 0;
}
