#include "lab/wire/times.h"

#include "base/check.h"
#include "base/quantile.h"
#include "lab/wire/wire_client.h"
#include "sim/thread_time.h"

namespace foreland::lab {

namespace {

constexpr int kPasses = 5;

// `begin()` makes what goes through the flight; work(it, i) takes it to keyframe i.
template <class Begin, class Work>
FlightSeconds medianOfPasses(size_t keyframes, const Begin& begin, const Work& work) {
  std::vector<double> first_s, rest_s;
  for (int pass = 0; pass < kPasses; ++pass) {
    auto traveller = begin();
    const double started = sim::threadSeconds();
    work(traveller, 0);
    const double first_done = sim::threadSeconds();
    for (size_t i = 1; i < keyframes; ++i) work(traveller, i);
    first_s.push_back(first_done - started);
    rest_s.push_back(sim::threadSeconds() - first_done);
  }
  return {median(first_s), median(rest_s)};
}

FlightSeconds timeAdapting(const server::Hierarchy& hierarchy, const std::vector<RecordedKeyframe>& flight) {
  proto::InMemoryNodes source = hierarchy.source();
  proto::AdaptScratch scratch;
  proto::CutDelta delta;
  return medianOfPasses(
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
  return medianOfPasses(
      views.size(), [&] { return server::SectionSender(hierarchy); },
      [&](server::SectionSender& sender, size_t i) {
        message.clear();
        sender.send(views[i], Time{} + keyframe_interval * static_cast<int64_t>(i), scratch, message);
      });
}

FlightSeconds timeDecoding(const server::Hierarchy& hierarchy, const std::vector<RecordedKeyframe>& flight) {
  return medianOfPasses(
      flight.size(), [&] { return WireClient(hierarchy); },
      [&](WireClient& client, size_t i) { client.take(flight[i].message); });
}

}  // namespace

WireTimes timeWire(const server::Hierarchy& hierarchy, const std::vector<proto::View>& views,
                   const std::vector<RecordedKeyframe>& flight, Duration keyframe_interval) {
  return {timeAdapting(hierarchy, flight), timeSending(hierarchy, views, keyframe_interval),
          timeDecoding(hierarchy, flight)};
}

}  // namespace foreland::lab
