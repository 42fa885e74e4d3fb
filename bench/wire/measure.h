// What a recorded flight costs on the wire, in bits and in processor time, and that what is decoded is what was coded.
#pragma once

#include <vector>

#include "bench/wire/flight.h"

namespace foreland::bench {

struct WireCosts {
  uint64_t keyframes = 0, nodes_added = 0, nodes_removed = 0;  // after the first keyframe
  double bits_per_added_node = 0;  // all bytes down after the first keyframe, over the nodes that they add
  double height_bits = 0;          // of that: heights
  double structure_bits = 0;       // which nodes come: answers to questions, radii
  double asked_per_added = 0;      // questions, for each node that comes
  double framing_bits = 0;         // headers: the keyframe's and WebSocket's
  double framing_share = 0;        // of all bytes down after the first keyframe
  double first_section_bits_per_node = 0, first_section_height_bits = 0, first_section_structure_bits = 0;
  uint64_t first_section_nodes = 0, first_section_bytes = 0;
  double kbit_per_s = 0;  // after the first keyframe
  // Over the whole flight, the first section included: nodes of objects that came to a section, those whose place was
  // sent (another object of the model did not have it), and what each node that came cost: which come and go, where
  // they are, and objects' share of framing by their share of the deltas' bits.
  uint64_t object_nodes_added = 0, object_places = 0;
  double bits_per_object_node = 0, object_structure_bits = 0, object_place_bits = 0, object_framing_bits = 0;
  // Millions of nodes that come or go per second (times.h), the first section apart. Encoding is what sending takes
  // beyond adaptation alone; decoding includes the adaptation that it steps.
  double encode_mnodes_per_s = 0, decode_mnodes_per_s = 0;
  double decode_beyond_adaptation_mnodes_per_s = 0;  // decoding less adaptation alone, as encoding is counted
  double send_mnodes_per_s = 0;                      // adaptation and encoding together
  double first_encode_mnodes_per_s = 0, first_decode_mnodes_per_s = 0;
  double encode_ms = 0, decode_ms = 0;  // means per keyframe
  uint32_t digest = 0;                  // of the last section (digest.h)
};

// Whole messages, as a session sends them, `views` being what it was asked for. Checks that both ends hold the same
// section and heights.
WireCosts measureWire(const server::Hierarchy& hierarchy, const std::vector<proto::View>& views,
                      const std::vector<RecordedKeyframe>& flight, Duration keyframe_interval);

}  // namespace foreland::bench
