#include "lab/martini/refine_speed.h"
#include "base/quantile.h"
#include "sim/thread_time.h"

namespace foreland::lab {

namespace {

constexpr size_t kNoLimit = size_t{1} << 30;

}  // namespace

RefineTimer::RefineTimer(const server::Hierarchy& hierarchy, std::vector<proto::View> views) : hierarchy_(hierarchy) {
  for (const proto::View& view : views) {
    CHECK_TRUE(
        server::refine(hierarchy_, view, kNoLimit, scratch_, section_));  // also grows the scratch and warms the pages
    samples_.push_back({.view = view,
                        .nodes = static_cast<double>(section_.slots.size()),
                        .triangles = static_cast<double>(proto::triangleCount(hierarchy_.grid(), section_)),
                        .seconds = {}});
  }
}

void RefineTimer::measure(int rounds) {
  for (int round = 0; round < rounds; ++round) {
    for (Sample& sample : samples_) {
      const double begin = sim::threadSeconds();
      CHECK_TRUE(server::refine(hierarchy_, sample.view, kNoLimit, scratch_, section_));
      sample.seconds.push_back(sim::threadSeconds() - begin);
    }
  }
}

RefineSpeed RefineTimer::speed() const {
  std::vector<double> nodes, triangles, ms, speeds;
  for (const Sample& sample : samples_) {
    const double seconds = median(sample.seconds);
    nodes.push_back(sample.nodes);
    triangles.push_back(sample.triangles);
    ms.push_back(1e3 * seconds);
    speeds.push_back(1e-6 * sample.triangles / seconds);
  }
  return {median(nodes), median(triangles), median(ms), median(speeds), medianDeviation(speeds)};
}

}  // namespace foreland::lab
