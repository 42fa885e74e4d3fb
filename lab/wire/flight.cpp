#include "lab/wire/flight.h"

namespace foreland::lab {

std::vector<RecordedKeyframe> recordFlight(const server::Hierarchy& hierarchy, const std::vector<proto::View>& views,
                                           Duration keyframe_interval, uint32_t memory_bytes) {
  server::SectionSender sender(hierarchy);
  sender.setMemory(memory_bytes);
  server::SendScratch scratch;
  std::vector<RecordedKeyframe> flight(views.size());
  for (size_t i = 0; i < views.size(); ++i) {
    RecordedKeyframe& k = flight[i];
    sender.send(views[i], Time{} + keyframe_interval * static_cast<int64_t>(i), scratch, k.message);
    k.view = proto::viewOf(sender.keyframe());
    k.added = scratch.delta.added.size();
    k.removed = scratch.delta.removed.size();
    k.delta_bytes = k.message.size() - sender.headerBytes();
    k.bits = sender.bits();
    k.object_bits = sender.objectBits();
    k.nodes = sender.adapter().nodeCount();
    k.known = sender.adapter().memory().pages.knownCount();
    k.memory_bytes = sender.adapter().memory().pages.bytes();
  }
  return flight;
}

}  // namespace foreland::lab
