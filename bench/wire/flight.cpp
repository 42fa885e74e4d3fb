#include "bench/wire/flight.h"

#include "bench/timing.h"

namespace foreland::bench {

std::vector<RecordedKeyframe> recordFlight(const server::Hierarchy& hierarchy, const std::vector<proto::View>& views,
                                           Duration keyframe_interval) {
  server::SectionSender sender(hierarchy);
  proto::TerrainAdapter plain(hierarchy.domain());
  proto::PlainNodes source = hierarchy.source();
  server::SendScratch scratch;
  std::vector<RecordedKeyframe> flight(views.size());
  for (size_t i = 0; i < views.size(); ++i) {
    RecordedKeyframe& k = flight[i];
    const double t0 = threadSeconds();
    sender.send(views[i], Time{} + keyframe_interval * static_cast<int64_t>(i), scratch, k.message);
    const double t1 = threadSeconds();
    k.added = scratch.delta.added.size();
    k.removed = scratch.delta.removed.size();
    scratch.delta.added.clear();
    scratch.delta.removed.clear();
    const double t2 = threadSeconds();
    CHECK_TRUE(plain.adapt(proto::viewOf(sender.keyframe()), hierarchy.grid().slotCount(), source, scratch.adapt,
                           scratch.delta));
    const double t3 = threadSeconds();
    k.delta_bytes = k.message.size() - sender.headerBytes();
    k.bits = sender.bits();
    k.object_bits = sender.objectBits();
    k.nodes = sender.adapter().nodeCount();
    k.send_s = t1 - t0;
    k.adapt_s = t3 - t2;
  }
  return flight;
}

}  // namespace foreland::bench
