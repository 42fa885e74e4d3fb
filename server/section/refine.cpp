#include "server/section/refine.h"

#include <array>
#include <utility>

#include "server/section/places.h"

namespace foreland::server {

namespace {

using proto::NodeId;
using proto::Slot;

// Lattice vectors and positions; differences may be negative, so signed.
struct Lattice {
  int32_t x, y;
};

template <class Places>
class Walk {
 public:
  Walk(const Hierarchy& hierarchy, const Metric& metric, size_t max_nodes, std::vector<Slot>& out)
      : grid_(hierarchy.grid()), nodes_(hierarchy.nodes().data()), metric_(metric), places_(hierarchy, metric), max_nodes_(max_nodes), out_(out) {}

  void run() {
    const int32_t size = static_cast<int32_t>(grid_.rootSize()), half = size / 2;
    for (int32_t y = half; y < static_cast<int32_t>(grid_.maxY()); y += size)
      for (int32_t x = half; x < static_cast<int32_t>(grid_.maxX()); x += size) {
        visit({x, y - half}, {half, 0}, grid_.maxLevel(), false);
        visit({x + half, y}, {0, half}, grid_.maxLevel(), false);
        visit({x, y + half}, {-half, 0}, grid_.maxLevel(), false);
        visit({x - half, y}, {0, -half}, grid_.maxLevel(), false);
      }
  }

 private:
  // The triangle with edge m - d, m + d and apex m + rot(d), rot(x, y) = (-y, x); `levels` are left below it, this one included.
  // Both triangles at an edge test the same node and agree, so no record of what was seen is needed.
  void visit(Lattice m, Lattice d, int levels, bool inside) {
    const NodeId n = NodeId::at(static_cast<uint32_t>(m.x), static_cast<uint32_t>(m.y));
    const Slot slot = grid_.slot(n);
    const terrain::NodeRecord& record = nodes_[slot];
    const double error = record.error.metres(), radius = record.radius.metres();
    if (error == 0) return;
    const Metric::Place place = places_(n.x(), n.y(), record.height);
    if (!inside) {
      const Metric::Fit fit = metric_.fit(place, radius);
      if (fit == Metric::Fit::kOutside) return;
      inside = fit == Metric::Fit::kInside;
    }
    if (!metric_.exceedsTolerance(place, radius, error)) return;
    if (isFirstApex(m, d)) out_.push_back(slot);
    if (--levels == 0 || out_.size() > max_nodes_) return;
    const Lattice rot{-d.y, d.x};
    const Lattice in{(rot.x - d.x) / 2, (rot.y - d.y) / 2}, on{(rot.x + d.x) / 2, (rot.y + d.y) / 2};
    visit({m.x + in.x, m.y + in.y}, {-on.x, -on.y}, levels, inside);
    visit({m.x + on.x, m.y + on.y}, in, levels, inside);
  }

  // Each node is written once: by the triangle whose apex is lower, or on the left, or the only one.
  static bool isFirstApex(Lattice m, Lattice d) {
    if (d.y == 0) return d.x < 0 || m.y == 0;
    if (d.x == 0) return d.y > 0 || m.x == 0;
    return d.x < 0;
  }

  const proto::GridTopology& grid_;
  const terrain::NodeRecord* nodes_;
  const Metric& metric_;
  Places places_;
  size_t max_nodes_;
  std::vector<Slot>& out_;
};

// Ascending order by two counting passes of 16 bits over slots below 2^32; stable, linear.
void sortSlots(std::vector<Slot>& slots, std::vector<Slot>& other) {
  other.resize(slots.size());
  std::array<uint32_t, 1 << 11> count;
  for (int shift = 0; shift < 33; shift += 11) {
    count.fill(0);
    for (Slot s : slots) ++count[s >> shift & 0x7ff];
    uint32_t sum = 0;
    for (uint32_t& c : count) c = std::exchange(sum, sum + c);
    for (Slot s : slots) other[count[s >> shift & 0x7ff]++] = s;
    slots.swap(other);
  }
}

}  // namespace

bool refine(const Hierarchy& hierarchy, const View& view, size_t max_nodes, RefineScratch& scratch, proto::Section& section) {
  const Metric metric(view, hierarchy.hasVerticalErrors());
  scratch.slots.clear();
  if (hierarchy.hasVerticalErrors()) Walk<PlanarPlaces>(hierarchy, metric, max_nodes, scratch.slots).run();
  else Walk<CurvedPlaces>(hierarchy, metric, max_nodes, scratch.slots).run();
  if (scratch.slots.size() > max_nodes) return false;
  sortSlots(scratch.slots, scratch.sorted);
  section.slots.assign(scratch.slots.begin(), scratch.slots.end());
  return true;
}

size_t triangleCount(const proto::GridTopology& grid, const proto::Section& section) {
  const proto::GridShape& shape = grid.shape();
  size_t count = size_t{4} * shape.roots_x * shape.roots_y + section.slots.size();
  for (Slot slot : section.slots) count += grid.apexes(grid.node(slot)).count - 1;
  return count;
}

}  // namespace foreland::server
