// Writes anew the corpora that follow from the code, after a change of a codec: record_corpus FOLDER
// (tests/fuzz/corpus). What fuzzers found, and what is no codec's (models, changes of files), stays.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

#include "base/rng.h"
#include "proto/codec/delta_codec.h"
#include "proto/codec/object_stream.h"
#include "proto/codec/section_codec.h"
#include "tests/fuzz/section_grids.h"
#include "tests/fuzz/toy_flight.h"
#include "tests/fuzz/toy_objects.h"

namespace foreland::test {
namespace {

using proto::TerrainAdapter;

// Deltas as a server sends them.
Bytes recordFlight(uint8_t how) {
  const ToyTerrain& terrain = toyFlightTerrain();
  const proto::DenseNodes table = terrain.table();
  const proto::Section begin = toyFlightBegin(how);
  proto::InMemoryNodes source(terrain.nodes());
  TerrainAdapter adapter =
      begin.slots.empty() ? TerrainAdapter(terrain.domain()) : TerrainAdapter(terrain.domain(), begin.slots, source);
  adapter.memory().pages.setBudget(toyFlightMemory(how));
  proto::DeltaModel model;
  Bytes input{how};
  for (int step = 0; step < kToySteps; ++step) {
    Bytes bytes;
    proto::CutDelta delta;
    proto::AdaptScratch scratch;
    proto::DeltaEncoder encoder(terrain.domain(), table, model, bytes);
    CHECK_TRUE(adapter.adapt(toyFlightView(how, step), proto::kMaxSectionNodes, encoder, scratch, delta));
    encoder.finish();
    appendToyDelta(bytes, input);
  }
  return input;
}

// The closed section of the nodes that can be there and that `keeps(node)` wants; asked in the order of slots.
template <class Topology, class Keeps>
proto::Section closedSection(const Topology& topology, const Keeps& keeps) {
  proto::Section section;
  const auto isIn = [&](proto::NodeId n) { return proto::contains(section, topology.slot(n)); };
  for (proto::Slot slot = topology.levelOffset(1); slot < topology.slotCount(); ++slot) {
    const proto::NodeId n = topology.node(slot);
    if (!topology.contains(n) || topology.isBase(n) || topology.slot(n) != slot) continue;  // padding
    const auto parents = topology.parents(n);
    if (std::all_of(parents.begin(), parents.end(), isIn) && keeps(n)) section.slots.push_back(slot);
  }
  return section;
}

// A grid's number, then a section of it: fine around one point, and coarser with the distance.
Bytes recordSection(uint8_t which, uint32_t at_x, uint32_t at_y) {
  const proto::GridTopology& grid = sectionGrids()[which];
  const proto::Section section = closedSection(grid, [&](proto::NodeId n) {
    return std::hypot(double(n.x()) - at_x, double(n.y()) - at_y) <= 3.0 * (1u << grid.scaleLog2(n));
  });
  CHECK_TRUE(validate(grid, section).ok());
  Bytes input{which};
  proto::encodeSections(grid, {}, {section, {}}, input);
  return input;
}

// Of the nodes that can be there two of three are.
proto::Section anySection(const proto::MeshTopology& mesh, Rng& rng) {
  return closedSection(mesh, [&](proto::NodeId) { return rng.below(3) > 0; });
}

// Where the nodes of a model are: anywhere.
std::vector<proto::SurfaceRecord> anyRecords(const proto::MeshTopology& mesh, Rng& rng) {
  std::vector<proto::SurfaceRecord> records(mesh.slotCount());
  for (proto::SurfaceRecord& r : records)
    r.position = {static_cast<int>(rng.below(900)), static_cast<int>(rng.below(900)), static_cast<int>(rng.below(900))};
  return records;
}

// Four keyframes of objects, some of which stay as they are.
Bytes recordObjects(uint8_t how) {
  Rng rng(how);
  const proto::ObjectSet& set = toyObjects();
  proto::ObjectStream stream(set);
  std::vector<std::vector<proto::SurfaceRecord>> records(2);
  for (size_t object = 0; object < 2; ++object)  // one of each model
    records[set.placement(object).model] = anyRecords(set.domain(object).topology(), rng);
  std::vector<glm::ivec3> moves;  // of the second model's poses but the first
  for (size_t i = 0; i < 2 * records[1].size(); ++i)
    moves.emplace_back(static_cast<int>(rng.below(200)), static_cast<int>(rng.below(2)), -90);
  const std::array<proto::ModelNodes, 2> nodes{{{records[0], {}, 0}, {records[1], moves, 2}}};
  Bytes input{how};
  for (int step = 0; step < kToySteps; ++step) {
    Bytes bytes;
    proto::RangeEncoder coder(bytes);
    proto::SurfaceBits bits;
    stream.begin(toyFlightView(how, step));
    for (size_t object = 0; object < set.size(); ++object) {
      const proto::Section before = stream.section(object);
      proto::CutDelta delta;
      proto::diff(before, rng.below(3) == 0 ? before : anySection(set.domain(object).topology(), rng), delta);
      stream.encode(object, delta, nodes[set.placement(object).model], coder, bits);
    }
    coder.finish();
    appendToyDelta(bytes, input);
  }
  return input;
}

struct Input {
  std::string path;  // in the folder of corpora
  Bytes bytes;
};

std::vector<Input> recordAll() {
  std::vector<Input> inputs;
  for (const int how : {0, 1, 2, 40, 41, 90, 91, 130, 200, 255})
    inputs.push_back({"deltas/flight_" + std::to_string(how), recordFlight(static_cast<uint8_t>(how))});
  for (const int how : {0, 7, 90, 200})
    inputs.push_back({"objects/flight_" + std::to_string(how), recordObjects(static_cast<uint8_t>(how))});
  inputs.push_back({"sections/least", recordSection(0, 1, 1)});
  inputs.push_back({"sections/several_roots", recordSection(1, 30, 70)});
  inputs.push_back({"sections/deep", recordSection(2, 700, 333)});
  return inputs;
}

}  // namespace
}  // namespace foreland::test

int main(int argc, char** argv) {
  if (argc != 2) {
    std::fprintf(stderr, "usage: %s FOLDER\n", argv[0]);
    return 2;
  }
  for (const foreland::test::Input& input : foreland::test::recordAll()) {
    const std::filesystem::path path = std::filesystem::path(argv[1]) / input.path;
    std::error_code failed;  // shows when the file cannot be written
    std::filesystem::create_directories(path.parent_path(), failed);
    std::ofstream file(path, std::ios::binary);
    file.write(reinterpret_cast<const char*>(input.bytes.data()), static_cast<std::streamsize>(input.bytes.size()));
    if (!file.flush()) {
      std::fprintf(stderr, "cannot write %s\n", path.c_str());
      return 2;
    }
    std::printf("%s: %zu bytes\n", path.c_str(), input.bytes.size());
  }
}
