#include "bench/sections/measure.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <thread>

#include "bench/allocation_count.h"
#include "bench/oracle/crack_checker.h"
#include "bench/oracle/lod_motion.h"
#include "bench/oracle/oracle.h"
#include "bench/oracle/scene_truth.h"
#include "bench/timing.h"
#include "client/replica.h"
#include "server/section/sender.h"
#include "server/session/world.h"

namespace foreland::bench {

namespace {

constexpr size_t kNoLimit = size_t{1} << 30;

double secondsNow() {
  return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

double quantile(std::vector<double> values, double q) {
  if (values.empty()) return 0;
  const auto at = values.begin() + static_cast<ptrdiff_t>(q * static_cast<double>(values.size() - 1));
  std::nth_element(values.begin(), at, values.end());
  return *at;
}

double sum(const std::vector<double>& values) {
  double total = 0;
  for (double v : values) total += v;
  return total;
}

}  // namespace

SectionCosts measureCosts(const server::Hierarchy& hierarchy, const std::vector<proto::View>& views) {
  proto::RefineScratch scratch;
  proto::Section section;
  proto::TerrainAdapter adapter(hierarchy.domain());
  proto::InMemoryNodes source = hierarchy.source();
  proto::AdaptScratch adapt_scratch;
  proto::CutDelta delta;
  std::vector<double> refine_s, adapt_s, triangles, nodes, changes, fractions;
  SectionCosts costs;
  uint64_t allocations_before = 0;
  for (size_t i = 0; i < views.size(); ++i) {
    const double t0 = threadSeconds();
    CHECK_TRUE(server::refine(hierarchy, views[i], kNoLimit, scratch, section));
    const double t1 = threadSeconds();
    delta.added.clear();
    delta.removed.clear();
    const uint64_t allocations = allocationCount();
    const double t2 = threadSeconds();
    CHECK_TRUE(adapter.adapt(views[i], kNoLimit, source, adapt_scratch, delta));
    const double t3 = threadSeconds();
    if (i > views.size() / 2) allocations_before += allocationCount() - allocations;
    CHECK_EQ(adapter.nodeCount(), section.slots.size());
    costs.bytes_per_node = std::max(
        costs.bytes_per_node, static_cast<double>(adapter.bytes()) / static_cast<double>(adapter.nodeCount() + 1));
    if (i == 0) continue;  // the first keyframe is refined from nothing by both
    refine_s.push_back(t1 - t0);
    adapt_s.push_back(t3 - t2);
    triangles.push_back(static_cast<double>(proto::triangleCount(hierarchy.grid(), section)));
    nodes.push_back(static_cast<double>(section.slots.size()));
    changes.push_back(static_cast<double>(delta.added.size() + delta.removed.size()));
    fractions.push_back(changes.back() / nodes.back());
  }
  const double n = static_cast<double>(nodes.size());
  costs.allocations = allocations_before;
  costs.nodes = sum(nodes) / n;
  costs.triangles = sum(triangles) / n;
  costs.changed_fraction = sum(fractions) / n;
  costs.refine_ms = 1e3 * quantile(refine_s, 0.5);
  costs.adapt_ms = 1e3 * quantile(adapt_s, 0.5);
  costs.refine_mtri_per_s = 1e-6 * sum(triangles) / sum(refine_s);
  costs.adapt_us_per_change = 1e6 * sum(adapt_s) / sum(changes);
  costs.ratio = costs.refine_ms / costs.adapt_ms;
  costs.keyframes_per_s_per_core = 1e3 / costs.adapt_ms;
  return costs;
}

double meanTriangles(const server::Hierarchy& hierarchy, const std::vector<proto::View>& views) {
  proto::RefineScratch scratch;
  proto::Section section;
  double total = 0;
  for (const proto::View& view : views) {
    CHECK_TRUE(server::refine(hierarchy, view, kNoLimit, scratch, section));
    total += static_cast<double>(proto::triangleCount(hierarchy.grid(), section));
  }
  return total / static_cast<double>(views.size());
}

Result<double> tauForTriangles(const server::Hierarchy& hierarchy, std::vector<proto::View> views, double triangles) {
  constexpr size_t kMostViews = 40;
  const size_t step = views.size() / kMostViews + 1;
  std::vector<proto::View> sample;
  for (size_t i = 0; i < views.size(); i += step) sample.push_back(views[i]);
  const auto with = [&](double tau_px) {
    for (proto::View& view : sample) view.tau_px = tau_px;
    return meanTriangles(hierarchy, sample);
  };
  double low = 0.01, high = 1000;
  for (int i = 0; i < 40; ++i) {
    const double middle = std::sqrt(low * high), got = with(middle);
    if (std::fabs(got - triangles) <= 0.01 * triangles) return middle;
    (got > triangles ? low : high) = middle;
  }
  return Error{ErrorCode::kInvalidArgument, "no tolerance gives so many triangles in the mean; ask for more or fewer"};
}

SectionErrors measureErrors(const server::Hierarchy& hierarchy, const std::vector<proto::View>& views,
                            const proto::Path& path, const FlightOptions& options, uint32_t frames_per_keyframe,
                            uint32_t measure_every) {
  const terrain::Scene& scene = hierarchy.scene();
  client::Replica replica(server::welcomeTo(hierarchy));
  server::SectionSender sender(hierarchy);
  server::SendScratch scratch;
  Truth truth{scene.frame(), scene.grid().shape(), [&scene](uint32_t x, uint32_t y, std::span<int32_t> out) {
                for (size_t i = 0; i < out.size(); ++i)
                  out[i] = scene.height(proto::NodeId::at(x + static_cast<uint32_t>(i), y));
              }};
  Oracle oracle(std::move(truth));
  SectionErrors errors;
  std::vector<double> motions;
  uint64_t frame = 0;
  for (size_t i = 0; i < views.size(); ++i) {
    Bytes message;
    sender.send(views[i], Time{} + options.keyframe_interval * static_cast<int64_t>(i), scratch, message);
    CHECK_TRUE(replica.apply(sender.keyframe(), ByteSpan(message).subspan(sender.headerBytes())).ok());
    const client::KeyframeMesh mesh = replica.buildMesh();
    errors.cracks += findCracks(mesh, scene.grid().shape()).cracks;
    const DrawnShare at_keyframe{&mesh, 1, 1};
    errors.max_error_px_keyframes =
        std::max(errors.max_error_px_keyframes, oracle.error({&at_keyframe, 1}, views[i].pose, options.lens).max_px);
    if (i == 0) continue;
    const Time begin = mesh.from.time;
    for (uint32_t f = 0; f < frames_per_keyframe; ++f) {
      if (frame++ % measure_every != 0) continue;
      const double weight = static_cast<double>(f) / frames_per_keyframe;
      const Time t = begin + Duration{options.keyframe_interval.us * f / frames_per_keyframe};
      const DrawnShare drawn{&mesh, weight, 1};
      const Deviation error = oracle.error({&drawn, 1}, path.at(t), options.lens);
      errors.max_error_px_frames = std::max(errors.max_error_px_frames, error.max_px);
      errors.frames_over_tau += error.max_px > options.tau_px ? 1 : 0;
      ++errors.frames;
    }
    const Time middle = begin + Duration{options.keyframe_interval.us / 2};
    collectLodMotion(mesh, {}, path.at(middle), options.lens, motions);
  }
  errors.lod_motion_px_per_frame = quantile(motions, 1) / frames_per_keyframe;
  errors.lod_motion_px_per_frame_p99 = quantile(motions, 0.99) / frames_per_keyframe;
  return errors;
}

double keyframesPerSecond(const server::Hierarchy& hierarchy, const std::vector<proto::View>& views, unsigned threads) {
  constexpr int kRounds = 3;
  const auto fly = [&] {
    for (int round = 0; round < kRounds; ++round) {
      proto::TerrainAdapter adapter(hierarchy.domain());
      proto::InMemoryNodes source = hierarchy.source();
      proto::AdaptScratch adapt_scratch;
      proto::CutDelta delta;
      for (const proto::View& view : views) {
        delta.added.clear();
        delta.removed.clear();
        CHECK_TRUE(adapter.adapt(view, kNoLimit, source, adapt_scratch, delta));
      }
    }
  };
  const double begin = secondsNow();
  {
    std::vector<std::jthread> pool;
    for (unsigned i = 0; i < threads; ++i) pool.emplace_back(fly);
  }
  return threads * kRounds * static_cast<double>(views.size()) / (secondsNow() - begin);
}

}  // namespace foreland::bench
