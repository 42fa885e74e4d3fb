#include "lab/sections/measure.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <thread>

#include "base/quantile.h"
#include "lab/allocation_count.h"
#include "server/section/sender.h"
#include "sim/thread_time.h"

namespace foreland::lab {

namespace {

constexpr size_t kNoLimit = size_t{1} << 30;

double secondsNow() {
  return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

double sum(const std::vector<double>& values) {
  double total = 0;
  for (double v : values) total += v;
  return total;
}

// Work done per second of the wall clock by `threads` threads, each adapting sessions of its own along the views.
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

}  // namespace

SectionCosts measureCosts(const server::Hierarchy& hierarchy, const std::vector<proto::View>& views) {
  proto::RefineScratch scratch;
  proto::Section section;
  proto::TerrainAdapter adapter(hierarchy.domain());
  adapter.memory().pages.setBudget(proto::kDefaultMemoryBytes);
  proto::InMemoryNodes source = hierarchy.source();
  proto::AdaptScratch adapt_scratch;
  proto::CutDelta delta;
  std::vector<double> refine_s, adapt_s, speeds, triangles, nodes, changes, fractions;
  SectionCosts costs;
  uint64_t allocations_before = 0;
  for (size_t i = 0; i < views.size(); ++i) {
    const double t0 = sim::threadSeconds();
    CHECK_TRUE(server::refine(hierarchy, views[i], kNoLimit, scratch, section));
    const double t1 = sim::threadSeconds();
    delta.added.clear();
    delta.removed.clear();
    const uint64_t allocations = allocationCount();
    const double t2 = sim::threadSeconds();
    CHECK_TRUE(adapter.adapt(views[i], kNoLimit, source, adapt_scratch, delta));
    const double t3 = sim::threadSeconds();
    if (i > views.size() / 2) allocations_before += allocationCount() - allocations;
    CHECK_EQ(adapter.nodeCount(), section.slots.size());
    if (i == 0) continue;  // the first keyframe is refined from nothing by both
    refine_s.push_back(t1 - t0);
    adapt_s.push_back(t3 - t2);
    triangles.push_back(static_cast<double>(proto::triangleCount(hierarchy.grid(), section)));
    speeds.push_back(1e-6 * triangles.back() / refine_s.back());
    nodes.push_back(static_cast<double>(section.slots.size()));
    changes.push_back(static_cast<double>(delta.added.size() + delta.removed.size()));
    fractions.push_back(changes.back() / nodes.back());
  }
  const double n = static_cast<double>(nodes.size());
  costs.allocations = allocations_before;
  costs.nodes = sum(nodes) / n;
  costs.triangles = sum(triangles) / n;
  costs.changed_fraction = sum(fractions) / n;
  costs.refine_ms = 1e3 * median(refine_s);
  costs.adapt_ms = 1e3 * median(adapt_s);
  costs.refine_mtri_per_s = median(speeds);
  costs.adapt_us_per_change = 1e6 * sum(adapt_s) / sum(changes);
  costs.ratio = costs.refine_ms / costs.adapt_ms;
  costs.keyframes_per_s_per_core = 1e3 / costs.adapt_ms;
  return costs;
}

SessionMemory measureMemory(const server::Hierarchy& hierarchy, const std::vector<proto::View>& views) {
  server::SendScratch scratch;
  Bytes message;
  SessionMemory memory;
  for (const bool is_counted : {false, true}) {  // the first pass grows what belongs to the worker
    const size_t before = liveBytes();
    server::SectionSender sender(hierarchy);
    for (size_t i = 0; i < views.size(); ++i) {
      message.clear();
      sender.send(views[i], Time{} + Duration::milliseconds(static_cast<int64_t>(i)), scratch, message);
      size_t nodes = sender.adapter().nodeCount();
      for (const proto::SurfaceAdapter& object : sender.objects()) nodes += object.nodeCount();
      if (!is_counted || liveBytes() == 0) continue;
      const double bytes = static_cast<double>(liveBytes() - before + sizeof(sender));
      memory.bytes = std::max(memory.bytes, bytes);
      memory.bytes_per_node = std::max(memory.bytes_per_node, bytes / static_cast<double>(std::max<size_t>(nodes, 1)));
    }
  }
  return memory;
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
  constexpr size_t kMaxViews = 40;
  const size_t step = views.size() / kMaxViews + 1;
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

SectionComparisons measureComparisons(const server::Hierarchy& hierarchy, const proto::Path& path,
                                      const FlightOptions& options) {
  const auto plain = keyframeViews(path, options, Guarantee::kKeyframesOnly),
             guaranteed = keyframeViews(path, options, Guarantee::kEveryFrame);
  // Hierarchies may share a scene, which outlives both.
  const std::shared_ptr<const terrain::Scene> scene(&hierarchy.scene(), [](const terrain::Scene*) {});
  const server::Hierarchy isotropic(scene, proto::ErrorBound::kSphere);
  const double triangles = meanTriangles(hierarchy, guaranteed);
  return {.two_threads_over_one =
              keyframesPerSecond(hierarchy, guaranteed, 2) / keyframesPerSecond(hierarchy, guaranteed, 1),
          .guarantee_triangle_overhead = triangles / meanTriangles(hierarchy, plain) - 1,
          .spheroid_triangle_saving = 1 - triangles / meanTriangles(isotropic, guaranteed)};
}

}  // namespace foreland::lab
