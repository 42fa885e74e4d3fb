#include "bench/wire/times.h"

#include <algorithm>
#include <limits>

#include "base/check.h"
#include "bench/timing.h"
#include "bench/wire/wire_client.h"

namespace foreland::bench {

namespace {

constexpr int kPasses = 3;

// `begin()` makes what goes through the flight; work(it, i) takes it to keyframe i.
template <class Begin, class Work>
FlightSeconds leastOfPasses(size_t keyframes, const Begin& begin, const Work& work) {
  constexpr double kEndless = std::numeric_limits<double>::infinity();
  FlightSeconds least{kEndless, kEndless};
  for (int pass = 0; pass < kPasses; ++pass) {
    auto traveller = begin();
    double at = threadSeconds(), first = 0;
    const double started = at;
    for (size_t i = 0; i < keyframes; ++i) {
      work(traveller, i);
      at = threadSeconds();
      if (i == 0) first = at - started;
    }
    least = {std::min(least.first_s, first), std::min(least.rest_s, at - started - first)};
  }
  return least;
}

FlightSeconds timeAdapting(const server::Hierarchy& hierarchy, const std::vector<RecordedKeyframe>& flight) {
  proto::InMemoryNodes source = hierarchy.source();
  proto::AdaptScratch scratch;
  proto::CutDelta delta;
  return leastOfPasses(
      flight.size(), [&] { return proto::TerrainAdapter(hierarchy.domain()); },
      [&](proto::TerrainAdapter& adapter, size_t i) {
        delta.added.clear();
        delta.removed.clear();
        CHECK_TRUE(adapter.adapt(flight[i].view, hierarchy.grid().slotCount(), source, scratch, delta));
      });
}

FlightSeconds timeSending(const server::Hierarchy& hierarchy, const std::vector<proto::View>& views,
                          Duration keyframe_interval) {
  server::SendScratch scratch;
  Bytes message;
  return leastOfPasses(
      views.size(), [&] { return server::SectionSender(hierarchy); },
      [&](server::SectionSender& sender, size_t i) {
        message.clear();
        sender.send(views[i], Time{} + keyframe_interval * static_cast<int64_t>(i), scratch, message);
      });
}

FlightSeconds timeDecoding(const server::Hierarchy& hierarchy, const std::vector<RecordedKeyframe>& flight) {
  return leastOfPasses(
      flight.size(), [&] { return WireClient(hierarchy); },
      [&](WireClient& client, size_t i) { client.take(flight[i].message); });
}

}  // namespace

WireTimes timeWire(const server::Hierarchy& hierarchy, const std::vector<proto::View>& views,
                   const std::vector<RecordedKeyframe>& flight, Duration keyframe_interval) {
  return {timeAdapting(hierarchy, flight), timeSending(hierarchy, views, keyframe_interval),
          timeDecoding(hierarchy, flight)};
}

}  // namespace foreland::bench
