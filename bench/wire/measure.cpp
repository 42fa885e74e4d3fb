#include "bench/wire/measure.h"

#include <time.h>

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

// A section as one bit a slot: what it costs to ask is left out of the codec's figures as far as can be.
class FlaggedNodes final : public proto::HeldNodes {
 public:
  explicit FlaggedNodes(const terrain::Scene& scene) : scene_(scene), words_(scene.grid().slotCount() / 64 + 1) {}
  void set(const proto::CutDelta& delta) {
    for (proto::Slot slot : delta.added) words_[slot >> 6] |= uint64_t{1} << (slot & 63);
    for (proto::Slot slot : delta.removed) words_[slot >> 6] &= ~(uint64_t{1} << (slot & 63));
  }
  bool has(proto::Slot slot) const override { return words_[slot >> 6] >> (slot & 63) & 1; }
  int32_t height(proto::NodeId v) const override { return scene_.height(v); }

 private:
  const terrain::Scene& scene_;
  std::vector<uint64_t> words_;
};

struct Sum {
  double height_bits = 0, structure_bits = 0, framing_bits = 0, encode_s = 0, decode_s = 0, nodes = 0, added = 0;
};

}  // namespace

WireCosts measureWire(const server::Hierarchy& hierarchy, const std::vector<RecordedKeyframe>& flight,
                      Duration keyframe_interval) {
  const terrain::Scene& scene = hierarchy.scene();
  FlaggedNodes sent(scene), received(scene);
  proto::DeltaModel encoder, decoder;
  WireCosts costs;
  Sum first, rest;
  for (size_t i = 0; i < flight.size(); ++i) {
    const RecordedKeyframe& keyframe = flight[i];
    Sum& sum = i == 0 ? first : rest;
    const proto::DeltaView view = proto::viewAsSent(keyframe.header);
    sent.set(keyframe.delta);
    Bytes message;
    proto::DeltaModel measured = encoder;
    const double t0 = processorSeconds();
    proto::encodeHeader(keyframe.header, message);
    const size_t header_bytes = message.size();
    proto::encodeDelta(scene.grid(), hierarchy.frame(), keyframe.delta, view, sent, encoder, message);
    const double t1 = processorSeconds();
    proto::HeightDelta got;
    const Status decoded = proto::decodeDelta(scene.grid(), hierarchy.frame(), ByteSpan(message).subspan(header_bytes),
                                              view, received, decoder, got);
    const double t2 = processorSeconds();
    CHECK_TRUE(decoded.ok());
    CHECK_TRUE(got.cut == keyframe.delta);
    for (size_t k = 0; k < got.heights.size(); ++k)
      CHECK_EQ(got.heights[k], scene.height(scene.grid().node(got.cut.added[k])));
    received.set(got.cut);
    Bytes again;
    proto::DeltaBits bits;
    proto::encodeDelta(scene.grid(), hierarchy.frame(), keyframe.delta, view, sent, measured, again, &bits);
    const double delta_bits = 8.0 * static_cast<double>(message.size() - header_bytes);
    sum.framing_bits += 8.0 * static_cast<double>(header_bytes);
    sum.height_bits += bits.heights;
    sum.structure_bits += delta_bits - bits.heights;
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
