#include "tests/protocol/expectation.h"

#include <bit>
#include <cstdio>

#include "proto/refine/places.h"

namespace foreland::test {

namespace {

// Of integers, lowest byte first: the CRC-32 of zlib and of Ethernet.
class Crc {
 public:
  void add(uint32_t value) {
    for (int i = 0; i < 32; ++i, value >>= 1) crc_ = crc_ >> 1 ^ (((crc_ ^ value) & 1) != 0 ? 0xedb88320u : 0);
  }
  void add(double value) {
    const uint64_t bits = std::bit_cast<uint64_t>(value);
    add(static_cast<uint32_t>(bits));
    add(static_cast<uint32_t>(bits >> 32));
  }
  uint32_t value() const { return ~crc_; }

 private:
  uint32_t crc_ = ~0u;
};

// The least number from 0 to 10^30 that passes, to the last bit, or 10^30. `passes` grows with the number.
template <class Passes>
double leastNumber(const Passes& passes) {
  constexpr double kMost = 1e30;
  if (passes(0.0)) return 0;
  uint64_t low = 0, high = std::bit_cast<uint64_t>(kMost);
  while (high - low > 1) {
    const uint64_t middle = (low + high) / 2;
    (passes(std::bit_cast<double>(middle)) ? high : low) = middle;
  }
  return std::bit_cast<double>(high);
}

// What the refinement test makes of a section's nodes, to the last bit: places, radii, least classes that pass; and of
// some the least error and the least radius that pass.
template <class Places>
uint32_t testsCrc(const server::Hierarchy& h, const proto::Section& section, const proto::Metric& metric) {
  const Places places(h.domain(), metric);
  Crc crc;
  for (proto::Slot slot : section.slots) {
    const proto::NodeId n = h.grid().node(slot);
    const proto::NodeRecord& record = h.nodes()[slot];
    const auto x = static_cast<int32_t>(n.x()), y = static_cast<int32_t>(n.y());
    const proto::Metric::Place p = places(x, y, record.middle());
    const float radius = h.domain().radius(h.grid().level(n), record.radius());
    for (double value : {p.x, p.y, p.z, p.horizontal}) crc.add(value);
    crc.add(std::bit_cast<uint32_t>(radius));
    crc.add(static_cast<uint32_t>(metric.leastPassing(p, radius)));
    if (slot % 32 != 0) continue;
    crc.add(leastNumber([&](double error_m) { return metric.passes(p, radius, error_m); }));
    crc.add(leastNumber([&](double radius_m) { return metric.passes(p, radius_m, 1e30); }));
  }
  return crc.value();
}

}  // namespace

proto::Section sectionOf(const server::Hierarchy& hierarchy, const proto::KeyframeHeader& keyframe) {
  proto::RefineScratch scratch;
  proto::Section section;
  CHECK_TRUE(refine(hierarchy, proto::viewOf(keyframe), hierarchy.grid().slotCount(), scratch, section));
  return section;
}

std::string expectedLine(const server::Hierarchy& hierarchy, const proto::KeyframeHeader& keyframe,
                         const proto::Section& before) {
  const proto::Section section = sectionOf(hierarchy, keyframe);
  proto::CutDelta delta;
  proto::diff(before, section, delta);
  Crc slots, heights;
  for (proto::Slot slot : section.slots) {
    slots.add(slot);
    heights.add(static_cast<uint32_t>(hierarchy.nodes()[slot].height()));
  }
  const proto::Metric metric = hierarchy.domain().metric(proto::viewOf(keyframe));
  const uint32_t tests = hierarchy.domain().isPlanar() ? testsCrc<proto::PlanarPlaces>(hierarchy, section, metric)
                                                       : testsCrc<proto::CurvedPlaces>(hierarchy, section, metric);
  char line[120];
  std::snprintf(line, sizeof(line), "%u %zu %zu %zu %08x %08x %08x %08x\n", keyframe.index, section.slots.size(),
                delta.added.size(), delta.removed.size(), proto::fingerprint(section.slots), slots.value(),
                heights.value(), tests);
  return line;
}

}  // namespace foreland::test
