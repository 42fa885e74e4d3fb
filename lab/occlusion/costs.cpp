#include "lab/occlusion/costs.h"

#include <algorithm>
#include <chrono>

#include "base/quantile.h"
#include "lab/occlusion/viewer_stream.h"
#include "oracle/reference/whole_mesh.h"
#include "sim/thread_time.h"

namespace foreland::lab {

namespace {

constexpr int kFirstPasses = 3;  // of the first keyframe, for it comes but once in a flight

double wallSeconds() {
  return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

double mean(const std::vector<double>& values) {
  double sum = 0;
  for (double v : values) sum += v;
  return values.empty() ? 0 : sum / static_cast<double>(values.size());
}

// Passes questions on and times them. By the wall clock, which is read in a tenth of the time that the thread's takes.
class TimedVisibility final : public proto::BlockVisibility, public server::ObjectVisibility {
  template <class Question>
  auto timed(const Question& question) {
    const double begin = wallSeconds();
    const auto answer = question();
    seconds_ += wallSeconds() - begin;
    return answer;
  }

 public:
  explicit TimedVisibility(Foresight& inner) : inner_(inner) {}

  void begin(const proto::View& view) override {
    timed([&] { return inner_.begin(view), true; });
  }
  bool isHidden(const proto::BlockId& block) override {
    return timed([&] { return inner_.isHidden(block); });
  }
  uint32_t changes(const proto::BlockId& lowest, uint32_t known, uint32_t hidden) override {
    return timed([&] { return inner_.changes(lowest, known, hidden); });
  }
  bool isObjectHidden(size_t object, size_t nodes) override {
    const double before = seconds_;
    const bool is_hidden = timed([&] { return inner_.isObjectHidden(object, nodes); });
    object_seconds_ += seconds_ - before;
    return is_hidden;
  }
  double seconds() const { return seconds_; }               // since the start
  double objectSeconds() const { return object_seconds_; }  // of these, for objects

 private:
  Foresight& inner_;
  double object_seconds_ = 0;
  double seconds_ = 0;
};

// One viewer's figures, keyframe by keyframe.
struct Series {
  std::vector<double> nodes, object_nodes, hidden_objects, bytes, added, hidden_bits, send_ms, decode_ms, mesh_ms;

  void keyframe(ViewerStream& stream, const proto::View& view, Time time) {
    const double begin = sim::threadSeconds();
    stream.send(view, time);
    send_ms.push_back(1e3 * (sim::threadSeconds() - begin));
    nodes.push_back(static_cast<double>(stream.sender().adapter().nodeCount()));
    object_nodes.push_back(static_cast<double>(stream.sender().nodeCount()) - nodes.back());
    hidden_objects.push_back(static_cast<double>(stream.sender().hiddenObjects()));
    bytes.push_back(static_cast<double>(stream.messageBytes()));
    added.push_back(static_cast<double>(stream.added()));
    hidden_bits.push_back(stream.sender().bits().blocks);
    const double sent = sim::threadSeconds();
    stream.take();
    const double taken = sim::threadSeconds();
    const client::KeyframeMesh mesh = oracle::wholeMesh(stream.replica());
    decode_ms.push_back(1e3 * (taken - sent));
    mesh_ms.push_back(1e3 * (sim::threadSeconds() - taken));
  }
};

std::vector<double> afterFirst(const std::vector<double>& values) { return {values.begin() + 1, values.end()}; }

// Sends and takes all views, or the first of them alone, twice; who begins alternates, for caches favour the second.
struct Passes {
  Series without, with;

  void fly(const server::Hierarchy& hierarchy, Foresight& visibility, std::span<const proto::View> views,
           Duration interval) {
    ViewerStream stream_without(hierarchy, nullptr), stream_with(hierarchy, &visibility, &visibility);
    for (size_t i = 0; i < views.size(); ++i) {
      const Time time = Time{} + interval * static_cast<int64_t>(i);
      for (const bool is_with : {i % 2 == 0, i % 2 != 0})
        (is_with ? with : without).keyframe(is_with ? stream_with : stream_without, views[i], time);
    }
  }
};

using Part = std::vector<double> Series::*;

BothWays meanAfterFirst(const Passes& passes, Part part) {
  return {mean(afterFirst(passes.without.*part)), mean(afterFirst(passes.with.*part))};
}
BothWays medianAfterFirst(const Passes& passes, Part part) {
  return {median(afterFirst(passes.without.*part)), median(afterFirst(passes.with.*part))};
}
BothWays medians(const Passes& passes, Part part) { return {median(passes.without.*part), median(passes.with.*part)}; }
BothWays firsts(const Passes& passes, Part part) { return {(passes.without.*part)[0], (passes.with.*part)[0]}; }

void measureFlight(const server::Hierarchy& hierarchy, const server::SceneOcclusion& occlusion,
                   const PredictedFlight& predicted, Duration interval, OcclusionCosts& costs) {
  server::ViewerOcclusion visibility(hierarchy, occlusion);
  Foresight foresight(visibility, predicted);
  Passes flight;
  flight.fly(hierarchy, foresight, predicted.views, interval);
  costs.viewer_occlusion_kib = static_cast<double>(visibility.bytes()) / 1024;
  costs.keyframes = predicted.views.size();
  costs.nodes = {mean(flight.without.nodes), mean(flight.with.nodes)};
  costs.first_nodes = firsts(flight, &Series::nodes);
  costs.object_nodes = {mean(flight.without.object_nodes), mean(flight.with.object_nodes)};
  costs.first_object_nodes = firsts(flight, &Series::object_nodes);
  costs.hidden_objects = mean(flight.with.hidden_objects);
  costs.bytes = meanAfterFirst(flight, &Series::bytes);
  costs.first_bytes = firsts(flight, &Series::bytes);
  costs.flight_bytes_saving = mean(flight.without.bytes) / mean(flight.with.bytes);
  costs.nodes_added = meanAfterFirst(flight, &Series::added);
  costs.hidden_bits_per_keyframe = mean(afterFirst(flight.with.hidden_bits));
  costs.first_hidden_bits = flight.with.hidden_bits[0];
  costs.keyframe_ms = medianAfterFirst(flight, &Series::send_ms);
  costs.decode_ms = medianAfterFirst(flight, &Series::decode_ms);
  costs.mesh_ms = medianAfterFirst(flight, &Series::mesh_ms);
}

void measureFirst(const server::Hierarchy& hierarchy, const server::SceneOcclusion& occlusion,
                  const PredictedFlight& predicted, OcclusionCosts& costs) {
  Passes passes;
  for (int i = 0; i < kFirstPasses; ++i) {
    server::ViewerOcclusion visibility(hierarchy, occlusion);
    Foresight foresight(visibility, predicted);
    passes.fly(hierarchy, foresight, std::span(predicted.views).first(1), {});
  }
  costs.first_keyframe_ms = medians(passes, &Series::send_ms);
  costs.first_decode_ms = medians(passes, &Series::decode_ms);
  costs.first_mesh_ms = medians(passes, &Series::mesh_ms);
}

// In a flight of its own, so that reading the clock is in no other figure.
void measureTests(const server::Hierarchy& hierarchy, const server::SceneOcclusion& occlusion,
                  const PredictedFlight& predicted, Duration interval, OcclusionCosts& costs) {
  server::ViewerOcclusion visibility(hierarchy, occlusion);
  Foresight foresight(visibility, predicted);
  TimedVisibility timed(foresight);
  const std::vector<proto::View>& views = predicted.views;
  ViewerStream stream(hierarchy, &timed, &timed);
  std::vector<double> ray_ms, shares, rays, speeds, tests, segments, queries, object_ms;
  for (size_t i = 0; i < views.size(); ++i) {
    const double asked_before = timed.seconds(), objects_before = timed.objectSeconds(), begin = wallSeconds();
    const server::OcclusionStatistics before = visibility.statistics();
    stream.send(views[i], Time{} + interval * static_cast<int64_t>(i));
    const double keyframe_s = wallSeconds() - begin, asked_s = timed.seconds() - asked_before;
    ray_ms.push_back(1e3 * asked_s);
    object_ms.push_back(1e3 * (timed.objectSeconds() - objects_before));
    shares.push_back(asked_s / keyframe_s);
    const server::OcclusionStatistics& after = visibility.statistics();
    rays.push_back(static_cast<double>(after.rays - before.rays));
    tests.push_back(static_cast<double>(after.tests - before.tests));
    segments.push_back(static_cast<double>(after.segments - before.segments));
    queries.push_back(static_cast<double>(after.queries - before.queries));
    if (rays.back() > 0) speeds.push_back(1e-6 * rays.back() / asked_s);
  }
  costs.first_ray_ms = ray_ms[0];
  costs.object_ms = median(afterFirst(object_ms));
  costs.first_object_ms = object_ms[0];
  costs.largest_object_ms = *std::max_element(object_ms.begin() + 1, object_ms.end());
  costs.queries_per_keyframe = mean(afterFirst(queries));
  costs.first_ray_share = shares[0];
  costs.first_rays = static_cast<uint64_t>(rays[0]);
  costs.ray_ms = median(afterFirst(ray_ms));
  costs.ray_share = median(afterFirst(shares));
  costs.rays_per_keyframe = mean(afterFirst(rays));
  costs.most_rays = *std::max_element(rays.begin() + 1, rays.end());
  costs.mrays_per_s = speeds.empty() ? 0 : median(speeds);
  costs.first_tests = static_cast<uint64_t>(tests[0]);
  costs.first_segments = static_cast<uint64_t>(segments[0]);
  costs.tests_per_keyframe = mean(afterFirst(tests));
  costs.most_tests = *std::max_element(tests.begin() + 1, tests.end());
  costs.segments_per_keyframe = mean(afterFirst(segments));
}

}  // namespace

OcclusionCosts measureOcclusionCosts(const server::Hierarchy& hierarchy, const server::SceneOcclusion& occlusion,
                                     const PredictedFlight& flight, Duration keyframe_interval) {
  CHECK_GT(flight.views.size(), 1u);
  OcclusionCosts costs;
  measureFlight(hierarchy, occlusion, flight, keyframe_interval, costs);
  measureFirst(hierarchy, occlusion, flight, costs);
  measureTests(hierarchy, occlusion, flight, keyframe_interval, costs);
  return costs;
}

}  // namespace foreland::lab
