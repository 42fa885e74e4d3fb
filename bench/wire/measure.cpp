#include "bench/wire/measure.h"

#include <time.h>

#include <unordered_map>

#include "proto/delta_codec.h"
#include "server/section/adapt.h"

namespace foreland::bench {

namespace {

// Of the calling thread, so that what else the machine does is left out.
double processorSeconds() {
  timespec t;
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t);
  return static_cast<double>(t.tv_sec) + 1e-9 * static_cast<double>(t.tv_nsec);
}

struct Sum {
  double height_bits = 0, structure_bits = 0, framing_bits = 0, encode_s = 0, decode_s = 0, nodes = 0, added = 0;
};

}  // namespace

WireCosts measureWire(const server::Hierarchy& hierarchy, const std::vector<RecordedKeyframe>& flight,
                      Duration keyframe_interval) {
  const terrain::Scene& scene = hierarchy.scene();
  const auto height_of = [&scene](proto::NodeId v) { return scene.height(v); };
  std::unordered_map<uint64_t, int32_t> held;
  const auto known = [&](proto::NodeId v) -> const int32_t* {
    if (scene.grid().isBase(v)) return &(held[v.bits] = scene.height(v));
    const auto it = held.find(v.bits);
    return it == held.end() ? nullptr : &it->second;
  };
  WireCosts costs;
  Sum first, rest;
  for (size_t i = 0; i < flight.size(); ++i) {
    const RecordedKeyframe& keyframe = flight[i];
    Sum& sum = i == 0 ? first : rest;
    Bytes message;
    const double t0 = processorSeconds();
    proto::encodeHeader(keyframe.header, message);
    const size_t header_bytes = message.size();
    proto::encodeDelta(scene.grid(), keyframe.delta, height_of, message);
    const double t1 = processorSeconds();
    proto::HeightDelta got;
    CHECK_TRUE(proto::decodeDelta(scene.grid(), ByteSpan(message).subspan(header_bytes), known, got).ok());
    const double t2 = processorSeconds();
    CHECK_TRUE(got.cut == keyframe.delta);
    for (size_t k = 0; k < got.heights.size(); ++k) held[scene.grid().node(got.cut.added[k]).bits] = got.heights[k];
    for (proto::Slot slot : got.cut.removed) held.erase(scene.grid().node(slot).bits);
    Bytes structure;
    ByteWriter writer(structure);
    proto::codec_detail::putSlots(keyframe.delta.removed, writer);
    proto::codec_detail::putSlots(keyframe.delta.added, writer);
    sum.framing_bits += 8.0 * static_cast<double>(header_bytes);
    sum.structure_bits += 8.0 * static_cast<double>(structure.size());
    sum.height_bits += 8.0 * static_cast<double>(message.size() - header_bytes - structure.size());
    sum.encode_s += t1 - t0;
    sum.decode_s += t2 - t1;
    sum.added += static_cast<double>(keyframe.delta.added.size());
    sum.nodes += static_cast<double>(keyframe.delta.added.size() + keyframe.delta.removed.size());
  }
  const double keyframes = static_cast<double>(flight.size() - 1),
               bits = rest.height_bits + rest.structure_bits + rest.framing_bits;
  costs.keyframes = flight.size() - 1;
  costs.nodes_added = static_cast<uint64_t>(rest.added);
  costs.nodes_removed = static_cast<uint64_t>(rest.nodes - rest.added);
  costs.bits_per_added_node = bits / rest.added;
  costs.height_bits = rest.height_bits / rest.added;
  costs.structure_bits = rest.structure_bits / rest.added;
  costs.framing_bits = rest.framing_bits / rest.added;
  const double first_bits = first.height_bits + first.structure_bits + first.framing_bits;
  costs.first_section_nodes = static_cast<uint64_t>(first.added);
  costs.first_section_bytes = static_cast<uint64_t>(first_bits / 8);
  costs.first_section_bits_per_node = first_bits / first.added;
  costs.first_section_height_bits = first.height_bits / first.added;
  costs.first_section_structure_bits = first.structure_bits / first.added;
  costs.kbit_per_s = 1e-3 * bits / (keyframes * keyframe_interval.toSeconds());
  costs.encode_mnodes_per_s = 1e-6 * rest.nodes / rest.encode_s;
  costs.decode_mnodes_per_s = 1e-6 * rest.nodes / rest.decode_s;
  costs.first_encode_mnodes_per_s = 1e-6 * first.nodes / first.encode_s;
  costs.first_decode_mnodes_per_s = 1e-6 * first.nodes / first.decode_s;
  costs.encode_ms = 1e3 * rest.encode_s / keyframes;
  costs.decode_ms = 1e3 * rest.decode_s / keyframes;
  return costs;
}

}  // namespace foreland::bench
