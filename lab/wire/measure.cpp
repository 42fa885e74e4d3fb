#include "lab/wire/measure.h"

#include "lab/wire/digest.h"
#include "lab/wire/times.h"
#include "lab/wire/wire_client.h"
#include "sim/framing.h"

namespace foreland::lab {

namespace {

struct Sum {
  double height_bits = 0, structure_bits = 0, framing_bits = 0, asked = 0, added = 0, removed = 0;
  double object_structure_bits = 0, object_position_bits = 0, object_framing_bits = 0;
  double object_positions = 0, object_added = 0;

  double bits() const { return height_bits + structure_bits + framing_bits; }  // the terrain's
  double objectBits() const { return object_structure_bits + object_position_bits; }
  double changed() const { return added + removed; }
};

// Both ends must hold the same, heights included.
void compare(const client::Replica& replica, const server::Hierarchy& hierarchy, size_t nodes) {
  const proto::Section held = replica.section();
  CHECK_EQ(held.slots.size(), nodes);
  for (proto::Slot slot : held.slots) {
    CHECK_TRUE(replica.nodes().in(slot)&client::kInTo);
    CHECK_EQ(replica.nodes().records().at(slot).height(), hierarchy.nodes()[slot].height());
  }
}

void addObjects(const proto::SurfaceBits& bits, double framing_bits, Sum& sum) {
  sum.object_structure_bits += bits.structure;
  sum.object_position_bits += bits.positions;
  sum.object_framing_bits += framing_bits;
  sum.object_positions += static_cast<double>(bits.positions_sent);
  sum.object_added += static_cast<double>(bits.added);
}

void shareObjects(const Sum& sum, WireCosts& costs) {
  costs.object_structure_bits = sum.object_structure_bits / sum.object_added;
  costs.object_position_bits = sum.object_position_bits / sum.object_added;
  costs.object_framing_bits = sum.object_framing_bits / sum.object_added;
  costs.bits_per_object_node = costs.object_structure_bits + costs.object_position_bits + costs.object_framing_bits;
}

void shareTimes(const WireTimes& times, double first_nodes, double changed, WireCosts& costs) {
  // 0 where a difference of two medians is lost in their noise.
  const auto rate = [](double nodes, double seconds) { return seconds > 0 ? 1e-6 * nodes / seconds : 0; };
  const double encode_s = times.send.rest_s - times.adapt.rest_s, decode_s = times.decode.rest_s;
  costs.encode_mnodes_per_s = rate(changed, encode_s);
  costs.send_mnodes_per_s = rate(changed, times.send.rest_s);
  costs.decode_mnodes_per_s = rate(changed, decode_s);
  costs.decode_beyond_adaptation_mnodes_per_s = rate(changed, decode_s - times.adapt.rest_s);
  costs.first_encode_mnodes_per_s = rate(first_nodes, times.send.first_s - times.adapt.first_s);
  costs.first_decode_mnodes_per_s = rate(first_nodes, times.decode.first_s);
  costs.encode_ms = 1e3 * encode_s / static_cast<double>(costs.keyframes);
  costs.decode_ms = 1e3 * decode_s / static_cast<double>(costs.keyframes);
}

uint64_t bytesDown(const std::vector<RecordedKeyframe>& flight) {
  uint64_t bytes = 0;
  for (const RecordedKeyframe& k : flight)
    bytes += k.message.size() + sim::frameHeaderBytes(k.message.size(), sim::Direction::kDown);
  return bytes;
}

}  // namespace

WireCosts measureWire(const server::Hierarchy& hierarchy, const std::vector<proto::View>& views,
                      const std::vector<RecordedKeyframe>& flight, Duration keyframe_interval) {
  WireClient client(hierarchy);
  WireCosts costs;
  Sum first, rest, all;
  for (size_t i = 0; i < flight.size(); ++i) {
    const RecordedKeyframe& k = flight[i];
    Sum& sum = i == 0 ? first : rest;
    client.take(k.message);
    compare(client.replica(), hierarchy, k.nodes);
    const size_t header_bytes = k.message.size() - k.delta_bytes;
    costs.nodes_sent += k.bits.added;
    const double framing_bits =
        8.0 * static_cast<double>(header_bytes + sim::frameHeaderBytes(k.message.size(), sim::Direction::kDown));
    const double delta_bits = 8.0 * static_cast<double>(k.delta_bytes);
    const double object_bits = k.object_bits.structure + k.object_bits.positions;
    sum.framing_bits += framing_bits;
    sum.height_bits += k.bits.heights;
    sum.structure_bits += delta_bits - k.bits.heights - object_bits;
    for (Sum* s : {&sum, &all}) addObjects(k.object_bits, framing_bits * object_bits / delta_bits, *s);
    sum.asked += static_cast<double>(k.bits.asked);
    sum.added += static_cast<double>(k.added);
    sum.removed += static_cast<double>(k.removed);
  }
  const double keyframes = static_cast<double>(flight.size() - 1);
  costs.keyframes = flight.size() - 1;
  costs.objects = hierarchy.objects().set.size();
  costs.nodes_added = static_cast<uint64_t>(rest.added);
  costs.nodes_removed = static_cast<uint64_t>(rest.removed);
  costs.asked_per_added = rest.asked / rest.added;
  costs.bits_per_added_node = rest.bits() / rest.added;
  costs.height_bits = rest.height_bits / rest.added;
  costs.structure_bits = rest.structure_bits / rest.added;
  costs.framing_bits = rest.framing_bits / rest.added;
  costs.framing_share = rest.framing_bits / rest.bits();
  costs.first_section_nodes = static_cast<uint64_t>(first.added);
  costs.first_section_bytes = static_cast<uint64_t>(first.bits() / 8);
  costs.first_section_bits_per_node = first.bits() / first.added;
  costs.first_section_height_bits = first.height_bits / first.added;
  costs.first_section_structure_bits = first.structure_bits / first.added;
  costs.object_nodes_added = static_cast<uint64_t>(all.object_added);
  costs.object_positions = static_cast<uint64_t>(all.object_positions);
  if (all.object_added > 0) shareObjects(all, costs);
  costs.kbit_per_s = 1e-3 * (rest.bits() + rest.objectBits()) / (keyframes * keyframe_interval.toSeconds());
  shareTimes(timeWire(hierarchy, views, flight, keyframe_interval), first.added, rest.changed(), costs);
  costs.bytes = bytesDown(flight);
  costs.bytes_without_memory = bytesDown(recordFlight(hierarchy, views, keyframe_interval, 0));
  costs.remembered_nodes = flight.back().known;
  costs.server_memory_bytes = flight.back().memory_bytes;
  costs.digest = digestOf(client.replica());
  return costs;
}

}  // namespace foreland::lab
