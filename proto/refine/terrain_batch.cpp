#include "proto/refine/terrain_batch.h"

#include <algorithm>
#include <cmath>

#include "proto/refine/places.h"

namespace foreland::proto {

namespace {

// Called through the linker: inlined into a caller that keeps batch and metric in one object, the compiler could not
// tell their memory apart and would not vectorise.
template <class Places>
void testAll(TerrainBatch& b, const Metric& metric, const Places& places) {
  for (size_t i = 0; i < b.count; ++i)
    b.passes[i] = metric.passes(places(b.x[i], b.y[i], b.height[i]), b.radius[i], b.error[i]);
}

template <class Places>
void testAllWithSlack(TerrainBatch& b, const Metric& metric, const Places& places, double share) {
  for (size_t i = 0; i < b.count; ++i) {
    const Metric::Place p = places(b.x[i], b.y[i], b.height[i]);
    const Metric::Outcome outcome = metric.outcome(p, b.radius[i], b.error[i]);
    const double safe = outcome.slack * share;
    b.guard[i] = static_cast<uint8_t>(outcome.guard);
    b.slack[i] = static_cast<float>(safe);
    b.reach[i] = static_cast<float>(std::max(std::sqrt(p.x * p.x + p.y * p.y + p.z * p.z), Metric::kNearest_m) + safe);
  }
}

template <class Places>
void findAllLeast(TerrainBatch& b, const Metric& metric, const Places& places) {
  for (size_t i = 0; i < b.count; ++i)
    b.least[i] = static_cast<uint16_t>(metric.leastPassing(places(b.x[i], b.y[i], b.height[i]), b.radius[i]));
}

}  // namespace

void TerrainBatch::findLeast(const TerrainDomain& domain, const Metric& metric) {
  if (domain.isPlanar())
    findAllLeast(*this, metric, PlanarPlaces(domain, metric));
  else
    findAllLeast(*this, metric, CurvedPlaces(domain, metric));
}

void TerrainBatch::test(const TerrainDomain& domain, const Metric& metric) {
  lookUpErrors();
  if (domain.isPlanar())
    testAll(*this, metric, PlanarPlaces(domain, metric));
  else
    testAll(*this, metric, CurvedPlaces(domain, metric));
}

void TerrainBatch::testWithSlack(const TerrainDomain& domain, const Metric& metric, double share) {
  lookUpErrors();
  if (domain.isPlanar())
    testAllWithSlack(*this, metric, PlanarPlaces(domain, metric), share);
  else
    testAllWithSlack(*this, metric, CurvedPlaces(domain, metric), share);
}

}  // namespace foreland::proto
