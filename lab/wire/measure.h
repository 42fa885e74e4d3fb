// What a recorded flight costs on the wire, in bits and in processor time, and that what is decoded is what was coded.
#pragma once

#include <vector>

#include "lab/wire/flight.h"

namespace foreland::lab {

struct WireCosts {
  uint64_t keyframes = 0, nodes_added = 0, nodes_removed = 0;  // after the first keyframe
  double bits_per_added_node = 0;  // all bytes down after the first keyframe, over the nodes that they add
  double height_bits = 0;          // of that: heights
  double structure_bits = 0;       // which nodes are added: decisions, radii
  double asked_per_added = 0;      // decisions coded, for each node that is added
  double framing_bits = 0;         // headers: the keyframe's and WebSocket's
  double framing_share = 0;        // of all bytes down after the first keyframe
  double first_section_bits_per_node = 0, first_section_height_bits = 0, first_section_structure_bits = 0;
  uint64_t first_section_nodes = 0, first_section_bytes = 0;
  double kbit_per_s = 0;  // after the first keyframe
  // Of the whole flight, the first section included: bytes down; nodes whose height was sent; and bytes down to a
  // client that remembers nothing.
  uint64_t bytes = 0, nodes_sent = 0, bytes_without_memory = 0;
  uint64_t remembered_nodes = 0, server_memory_bytes = 0;  // at the flight's end
  // Over the whole flight, the first section included: nodes added to the sections of objects, those of them whose
  // position was sent (no other object of the model had it), and the bits of each node added: which nodes are added and
  // removed, their positions, and objects' share of framing by their share of the deltas' bits.
  uint64_t object_nodes_added = 0, object_positions = 0;
  double bits_per_object_node = 0, object_structure_bits = 0, object_position_bits = 0, object_framing_bits = 0;
  // Millions of nodes added or removed per second (times.h), the first section apart. Encoding is what sending takes
  // beyond adaptation alone; decoding includes the client's adaptation.
  double encode_mnodes_per_s = 0, decode_mnodes_per_s = 0;
  double decode_beyond_adaptation_mnodes_per_s = 0;  // decoding less adaptation alone, as encoding is counted
  double send_mnodes_per_s = 0;                      // adaptation and encoding together
  double first_encode_mnodes_per_s = 0, first_decode_mnodes_per_s = 0;
  double encode_ms = 0, decode_ms = 0;  // means per keyframe
  uint32_t digest = 0;                  // of the last section (digest.h); not a figure
  uint64_t objects = 0;                 // that stand in the scene

  template <class Visit>
  void fields(const Visit& visit) const {
    visit("keyframes", keyframes);
    visit("nodes_added", nodes_added);
    visit("nodes_removed", nodes_removed);
    visit("bits_per_added_node", bits_per_added_node);
    visit("height_bits", height_bits);
    visit("structure_bits", structure_bits);
    visit("asked_per_added", asked_per_added);
    visit("framing_bits", framing_bits);
    visit("framing_share", framing_share);
    visit("first_section_nodes", first_section_nodes);
    visit("first_section_bytes", first_section_bytes);
    visit("first_section_bits_per_node", first_section_bits_per_node);
    visit("first_section_height_bits", first_section_height_bits);
    visit("first_section_structure_bits", first_section_structure_bits);
    visit("kbit_per_s", kbit_per_s);
    visit("bytes", bytes);
    visit("nodes_sent", nodes_sent);
    visit("bytes_without_memory", bytes_without_memory);
    visit("remembered_nodes", remembered_nodes);
    visit("server_memory_bytes", server_memory_bytes);
    visit("objects", objects);
    visit("object_nodes_added", object_nodes_added);
    visit("object_positions", object_positions);
    visit("bits_per_object_node", bits_per_object_node);
    visit("object_structure_bits", object_structure_bits);
    visit("object_position_bits", object_position_bits);
    visit("object_framing_bits", object_framing_bits);
    visit("encode_mnodes_per_s", encode_mnodes_per_s);
    visit("decode_mnodes_per_s", decode_mnodes_per_s);
    visit("decode_beyond_adaptation_mnodes_per_s", decode_beyond_adaptation_mnodes_per_s);
    visit("send_mnodes_per_s", send_mnodes_per_s);
    visit("first_encode_mnodes_per_s", first_encode_mnodes_per_s);
    visit("first_decode_mnodes_per_s", first_decode_mnodes_per_s);
    visit("encode_ms", encode_ms);
    visit("decode_ms", decode_ms);
  }
};

// Whole messages, as a session sends them, `views` being those of its keyframes. Checks that both ends hold the same
// section and heights.
WireCosts measureWire(const server::Hierarchy& hierarchy, const std::vector<proto::View>& views,
                      const std::vector<RecordedKeyframe>& flight, Duration keyframe_interval);

}  // namespace foreland::lab
