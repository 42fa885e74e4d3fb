#include "bench/wire/flight.h"

#include "server/section/adapt.h"

namespace foreland::bench {

std::vector<RecordedKeyframe> recordFlight(const server::Hierarchy& hierarchy, const std::vector<server::View>& views,
                                           Duration keyframe_interval) {
  server::Adapter adapter(hierarchy);
  server::AdaptScratch scratch;
  std::vector<RecordedKeyframe> flight(views.size());
  proto::KeyframeHeader header;
  for (size_t i = 0; i < views.size(); ++i) {
    // As a session does: the section is computed for the pose that the client decodes.
    server::View view = views[i];
    view.pose = proto::asSent(view.pose);
    proto::CutDelta& delta = flight[i].delta;
    CHECK_TRUE(adapter.adapt(view, hierarchy.grid().slotCount(), scratch, delta));
    server::settle(delta);
    header.base_index = header.index++;
    header.time = Time{} + keyframe_interval * static_cast<int64_t>(i);
    header.pose = view.pose;
    header.tau_px = static_cast<float>(view.tau_px);
    header.ball_m = static_cast<float>(view.ball_m);
    header.turn_rad = static_cast<float>(view.turn_rad);
    header.fingerprint += proto::fingerprint(delta.added) - proto::fingerprint(delta.removed);
    flight[i].header = header;
  }
  return flight;
}

}  // namespace foreland::bench
