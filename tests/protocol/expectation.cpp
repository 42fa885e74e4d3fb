#include "tests/protocol/expectation.h"

#include <algorithm>
#include <bit>
#include <cstdio>

#include "oracle/epoch_shares.h"
#include "proto/refine/metric/node_positions.h"

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
  constexpr double kMax = 1e30;
  if (passes(0.0)) return 0;
  uint64_t low = 0, high = std::bit_cast<uint64_t>(kMax);
  while (high - low > 1) {
    const uint64_t middle = (low + high) / 2;
    (passes(std::bit_cast<double>(middle)) ? high : low) = middle;
  }
  return std::bit_cast<double>(high);
}

// The numbers in the refinement test of a section's nodes, to the last bit: view-space positions, radii, least
// quantised errors that pass; and of some the least error and the least radius that pass.
template <class Positions>
uint32_t testsCrc(const server::Hierarchy& h, const proto::Section& section, const proto::Metric& metric) {
  const Positions positions(h.domain(), metric);
  Crc crc;
  for (proto::Slot slot : section.slots) {
    const proto::NodeId n = h.grid().node(slot);
    const proto::NodeRecord& record = h.nodes()[slot];
    const auto x = static_cast<int32_t>(n.x()), y = static_cast<int32_t>(n.y());
    const proto::NodePosition p = positions(x, y, record.middle());
    const float radius = h.domain().radius(h.grid().level(n), record.radius());
    for (double value : {p.x, p.y, p.z, p.horizontal}) crc.add(value);
    crc.add(std::bit_cast<uint32_t>(radius));
    crc.add(static_cast<uint32_t>(metric.leastPassing(p, radius)));
    if (slot % 32 != 0) continue;
    crc.add(leastNumber([&](double error_m) { return metric.passes(p, radius, error_m); }));
    crc.add(leastNumber(
        [&](double radius_m) { return metric.passes(p, radius_m, 1e30) && !metric.horizon().hides(p, radius_m); }));
  }
  return crc.value();
}

// An object's records and their test at a view.
struct SurfaceTable {
  const proto::SurfaceDomain& domain;
  std::span<const proto::SurfaceRecord> records;
  proto::SurfaceMetric metric;

  SurfaceTable(const server::Hierarchy& h, size_t object, const proto::View& view)
      : domain(h.objects().set.domain(object)),
        records(h.objects().recordsOf(object)),
        metric(domain.metric(h.objects().set.placement(object).toObject(view))) {}
  proto::SurfaceBounds bounds(proto::Slot slot) const {
    return proto::SurfaceBounds::of(records[slot], domain.quantum_m);
  }
};

// A node is in the section if it passes and its parents are there, which have lower slots.
proto::Section sectionOf(const SurfaceTable& object) {
  const proto::MeshTopology& mesh = object.domain.topology();
  std::vector<bool> is_in(mesh.slotCount());
  proto::Section section;
  for (proto::Slot slot = 0; slot < mesh.slotCount(); ++slot) {
    const proto::NodeId n = mesh.node(slot);
    if (mesh.isBase(n)) continue;
    const auto parents = mesh.parents(n);
    is_in[slot] = std::all_of(parents.begin(), parents.end(), [&](proto::NodeId p) { return is_in[mesh.slot(p)]; }) &&
                  object.metric.passes(object.bounds(slot));
    if (is_in[slot]) section.slots.push_back(slot);
  }
  return section;
}

std::string terrainColumns(const server::Hierarchy& hierarchy, const proto::View& view,
                           const proto::HeldSections& before, const proto::HeldSections& now) {
  proto::CutDelta delta;
  proto::diff(before.terrain, now.terrain, delta);
  Crc slots, heights;
  for (proto::Slot slot : now.terrain.slots) {
    slots.add(static_cast<uint32_t>(slot));
    heights.add(static_cast<uint32_t>(hierarchy.nodes()[slot].height()));
  }
  const proto::Metric metric = hierarchy.domain().metric(view);
  const uint32_t tests = hierarchy.domain().isPlanar()
                             ? testsCrc<proto::PlanarPositions>(hierarchy, now.terrain, metric)
                             : testsCrc<proto::CurvedPositions>(hierarchy, now.terrain, metric);
  char text[120];
  std::snprintf(text, sizeof(text), "%zu %zu %zu %08x %08x %08x %08x", now.terrain.slots.size(), delta.added.size(),
                delta.removed.size(), proto::fingerprint(now), slots.value(), heights.value(), tests);
  return text;
}

std::string objectColumns(const server::Hierarchy& hierarchy, const proto::HeldSections& before,
                          const proto::HeldSections& now) {
  size_t nodes = 0, added = 0, removed = 0;
  Crc slots, positions;
  for (size_t i = 0; i < now.objects.size(); ++i) {
    const std::span<const proto::SurfaceRecord> records = hierarchy.objects().recordsOf(i);
    const proto::Section& section = now.objects[i];
    proto::CutDelta delta;
    proto::diff(before.objects[i], section, delta);
    nodes += section.slots.size();
    added += delta.added.size();
    removed += delta.removed.size();
    slots.add(static_cast<uint32_t>(section.slots.size()));
    for (proto::Slot slot : section.slots) {
      slots.add(static_cast<uint32_t>(slot));
      for (int axis = 0; axis < 3; ++axis) positions.add(static_cast<uint32_t>(records[slot].position[axis]));
      for (const glm::ivec3& move : hierarchy.objects().nodesOf(i).movesOf(slot))
        for (int axis = 0; axis < 3; ++axis) positions.add(static_cast<uint32_t>(move[axis]));
    }
  }
  char text[120];
  std::snprintf(text, sizeof(text), " %zu %zu %zu %08x %08x", nodes, added, removed, slots.value(), positions.value());
  return text;
}

// Of a scene time, and of the offsets of a section's nodes at the epochs around it.
std::string epochColumns(const server::Hierarchy& hierarchy, Time scene_time, const proto::Section& section) {
  const terrain::EpochTable& table = hierarchy.epochs();
  Crc crc;
  crc.add(static_cast<uint32_t>(scene_time.us));
  crc.add(static_cast<uint32_t>(static_cast<uint64_t>(scene_time.us) >> 32));
  std::vector<Time> dates;
  for (const proto::Epoch& epoch : table.epochs().all()) dates.push_back(epoch.time);
  const std::vector<double> shares = oracle::epochShares(dates, table.epochs().blend(), scene_time);
  for (uint32_t epoch = 0; epoch < shares.size(); ++epoch) {
    if (shares[epoch] == 0) continue;
    for (proto::Slot slot : section.slots) crc.add(static_cast<uint32_t>(table.offset(epoch, slot)));
  }
  char text[16];
  std::snprintf(text, sizeof(text), " %08x", crc.value());
  return text;
}

}  // namespace

proto::HeldSections emptySections(const server::Hierarchy& hierarchy) {
  return {{}, std::vector<proto::Section>(hierarchy.objects().set.size())};
}

proto::HeldSections sectionsOf(const server::Hierarchy& hierarchy, const proto::KeyframeHeader& keyframe) {
  proto::RefineScratch scratch;
  proto::HeldSections sections = emptySections(hierarchy);
  const proto::View view = proto::viewOf(keyframe);
  CHECK_TRUE(refine(hierarchy, view, hierarchy.grid().slotCount(), scratch, sections.terrain));
  for (size_t i = 0; i < sections.objects.size(); ++i)
    sections.objects[i] = sectionOf(SurfaceTable(hierarchy, i, view));
  return sections;
}

std::string expectedLine(const server::Hierarchy& hierarchy, const proto::KeyframeHeader& keyframe,
                         const proto::HeldSections& before) {
  const proto::HeldSections now = sectionsOf(hierarchy, keyframe);
  const proto::View view = proto::viewOf(keyframe);
  std::string line = std::to_string(keyframe.index) + ' ' + terrainColumns(hierarchy, view, before, now);
  if (!now.objects.empty()) line += objectColumns(hierarchy, before, now);
  if (!hierarchy.epochs().epochs().empty()) line += epochColumns(hierarchy, keyframe.scene_time, now.terrain);
  return line + '\n';
}

}  // namespace foreland::test
