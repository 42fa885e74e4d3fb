#include "proto/refine/refine.h"

#include <algorithm>
#include <array>
#include <utility>

#include "proto/refine/terrain_batch.h"

namespace foreland::proto {

namespace {

NodeId idOf(LatticePoint p) { return NodeId::at(static_cast<uint32_t>(p.x), static_cast<uint32_t>(p.y)); }

// Level by level. Whatever passes has parents that pass, so it is enough to reach each node from one of its parents:
// the lower one, or the one on the left, or the only one. Each node is then tested once.
class Descent {
 public:
  Descent(const TerrainDomain& domain, std::span<const NodeRecord> nodes, const Metric& metric, RefineScratch& scratch,
          const HiddenBlocks* hidden)
      : domain_(domain),
        grid_(domain.grid),
        nodes_(nodes.data()),
        metric_(metric),
        scratch_(scratch),
        hidden_(hidden),
        max_x_(static_cast<int32_t>(grid_.maxX())),
        max_y_(static_cast<int32_t>(grid_.maxY())) {}

  // False if there are more than `max_nodes`.
  bool run(size_t max_nodes) {
    scratch_.slots.clear();
    scratch_.in_section.clear();
    const int32_t size = static_cast<int32_t>(grid_.rootSize());
    for (int32_t y = size / 2; y < max_y_; y += size)
      for (int32_t x = size / 2; x < max_x_; x += size) scratch_.in_section.push_back({x, y});
    for (level_ = 1; level_ <= grid_.maxLevel() && !scratch_.in_section.empty(); ++level_) {
      scratch_.next.clear();
      const int32_t s = 1 << (static_cast<int>(grid_.shape().root_log2) - 1 - level_ / 2);
      if (level_ & 1)
        sidesOf(s);
      else
        centresOf(s);
      flush();
      scratch_.in_section.swap(scratch_.next);
      if (scratch_.slots.size() > max_nodes) return false;
    }
    return true;
  }

 private:
  // The sides of squares of 2s around the active centres.
  void sidesOf(int32_t s) {
    for (const LatticePoint p : scratch_.in_section) {
      push({p.x + s, p.y});
      push({p.x, p.y + s});
      if (p.x == s) push({0, p.y});
      if (p.y == s) push({p.x, 0});
    }
  }
  // The centres of squares of 2s to the right of the active sides, which are s away from them both ways.
  void centresOf(int32_t s) {
    for (const LatticePoint p : scratch_.in_section) {
      if (p.x == max_x_) continue;
      if (p.y > 0) push({p.x + s, p.y - s});
      if (p.y < max_y_) push({p.x + s, p.y + s});
    }
  }

  void push(LatticePoint p) {
    batch_.push(idOf(p), grid_.slot(idOf(p)), level_);
    if (batch_.full()) flush();
  }

  void flush() {
    for (size_t i = 0; i < batch_.count; ++i) {
      const NodeRecord record = nodes_[batch_.slot[i]];
      batch_.height[i] = record.middle();
      batch_.bound[i] = record.error();
      batch_.radius[i] = domain_.spheres.radius(level_, record.radius());
    }
    batch_.test(domain_, metric_);
    for (size_t i = 0; i < batch_.count; ++i) {
      if (!batch_.passes[i]) continue;
      if (hidden_ && hidden_->isKnownHidden(idOf({batch_.x[i], batch_.y[i]}))) continue;
      scratch_.slots.push_back(batch_.slot[i]);
      scratch_.next.push_back({batch_.x[i], batch_.y[i]});
    }
    batch_.count = 0;
  }

  const TerrainDomain& domain_;
  const GridTopology& grid_;
  const NodeRecord* nodes_;
  const Metric& metric_;
  RefineScratch& scratch_;
  const HiddenBlocks* hidden_;
  int32_t max_x_, max_y_;
  int level_ = 0;
  TerrainBatch batch_;
};

// Ascending order by three counting passes of 11 bits; stable, linear.
void sortSlots(std::vector<Slot>& slots, std::vector<Slot>& other) {
  other.resize(slots.size());
  std::array<std::array<uint32_t, 1 << 11>, 3> count{};
  for (Slot s : slots)
    for (int pass = 0; pass < 3; ++pass) ++count[pass][s >> (11 * pass) & 0x7ff];
  for (int pass = 0; pass < 3; ++pass) {
    uint32_t sum = 0;
    for (uint32_t& c : count[pass]) c = std::exchange(sum, sum + c);
    for (Slot s : slots) other[count[pass][s >> (11 * pass) & 0x7ff]++] = s;
    slots.swap(other);
  }
}

}  // namespace

bool refine(const TerrainDomain& domain, std::span<const NodeRecord> nodes, const View& view, size_t max_nodes,
            RefineScratch& scratch, Section& section, const HiddenBlocks* hidden) {
  const Metric metric(view, domain.has_vertical_errors);
  const bool fits = Descent(domain, nodes, metric, scratch, hidden).run(max_nodes);
  if (!fits) return false;
  sortSlots(scratch.slots, scratch.sorted);
  section.slots.assign(scratch.slots.begin(), scratch.slots.end());
  return true;
}

size_t triangleCount(const GridTopology& grid, const Section& section) {
  const GridShape& shape = grid.shape();
  size_t count = size_t{4} * shape.roots_x * shape.roots_y + section.slots.size();
  for (Slot slot : section.slots) count += grid.apexes(grid.node(slot)).count - 1;
  return count;
}

}  // namespace foreland::proto
