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
  Descent(const TerrainDomain& domain, const StoredNodes& nodes, const Metric& metric, RefineScratch& scratch,
          const HiddenBlocks* hidden, ReadableNodes* readable)
      : domain_(domain),
        grid_(domain.grid),
        nodes_(nodes),
        metric_(metric),
        scratch_(scratch),
        hidden_(hidden),
        readable_(readable),
        max_x_(static_cast<int32_t>(grid_.maxX())),
        max_y_(static_cast<int32_t>(grid_.maxY())) {}

  // False if there are more than `max_nodes`.
  bool run(size_t max_nodes) {
    return descend([&] { return scratch_.slots.size() <= max_nodes; });
  }

  // A level's nodes that are followed stand for `weight` of them each.
  SampledSize estimate(const Metric& inner) {
    constexpr size_t kFollowed = 2048;  // at most, of a level
    SampledSize size;
    double weight = 1;
    inner_ = &inner;
    (void)descend([&] {
      size.nodes += weight * static_cast<double>(scratch_.slots.size() - size.sample);
      size.within += weight * static_cast<double>(std::exchange(within_, 0));
      size.sample = scratch_.slots.size();
      for (; scratch_.in_section.size() > kFollowed; weight *= 2) halve(scratch_.in_section);
      return true;
    });
    return size;
  }

 private:
  // Calls goOn() after each level, whose nodes are in scratch_.in_section then, until it is false, which is returned.
  template <class GoOn>
  bool descend(const GoOn& goOn) {
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
      if (!goOn()) return false;
    }
    return true;
  }
  // Keeps one of each two neighbours, which one as if by chance: siblings lie to the same sides of their parents.
  static void halve(std::vector<LatticePoint>& points) {
    size_t kept = 0;
    for (size_t i = 0; i < points.size(); i += 2) {
      const uint32_t mixed =
          static_cast<uint32_t>(points[i].x) * 0x9e3779b1u ^ static_cast<uint32_t>(points[i].y) * 0x85ebca77u;
      const size_t chosen = i + (mixed >> 31);
      if (chosen < points.size()) points[kept++] = points[chosen];
    }
    points.resize(kept);
  }

  // The sides of squares of 2s around the active centres.
  void sidesOf(int32_t s) {
    for (const LatticePoint p : scratch_.in_section) {
      if (grid_.isCube()) {
        const auto sides = grid_.children(idOf(p), level_ - 1);
        push(sides.ids[1]);
        push(sides.ids[3]);
        continue;
      }
      push({p.x + s, p.y});
      push({p.x, p.y + s});
      if (p.x == s) push({0, p.y});
      if (p.y == s) push({p.x, 0});
    }
  }
  // The centres of squares of 2s to the right of the active sides, which are s away from them both ways.
  void centresOf(int32_t s) {
    for (const LatticePoint p : scratch_.in_section) {
      if (grid_.isOnSeam(idOf(p))) {
        for (const NodeId centre : grid_.children(idOf(p), level_ - 1))
          if (grid_.apexes(centre, level_).ids[0] == idOf(p)) push(centre);
        continue;
      }
      if (p.x == max_x_) continue;
      if (p.y > 0) push({p.x + s, p.y - s});
      if (p.y < max_y_) push({p.x + s, p.y + s});
    }
  }

  void push(LatticePoint p) { push(idOf(p)); }
  void push(NodeId n) {
    const Slot slot = grid_.slot(n);
    if (readable_ && !readable_->isReadable(slot)) return;
    batch_.push(n, slot, level_);
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
    if (inner_) countWithin();
    batch_.count = 0;
  }

  void countWithin() {
    const auto outer = batch_.passes;
    batch_.test(domain_, *inner_);
    for (size_t i = 0; i < batch_.count; ++i) within_ += outer[i] & batch_.passes[i];
  }

  const TerrainDomain& domain_;
  const GridTopology& grid_;
  StoredNodes nodes_;
  const Metric& metric_;
  RefineScratch& scratch_;
  const HiddenBlocks* hidden_;
  ReadableNodes* readable_;
  int32_t max_x_, max_y_;
  int level_ = 0;
  const Metric* inner_ = nullptr;  // of the smaller section that is counted, too, if any
  size_t within_ = 0;              // its nodes of the level
  TerrainBatch batch_;
};

// Ascending order of slots below `end` by counting passes of 11 bits; stable, linear.
void sortSlots(std::vector<Slot>& slots, std::vector<Slot>& other, Slot end) {
  constexpr int kDigit = 11;
  other.resize(slots.size());
  for (int shift = 0; shift < kSlotBits && end >> shift != 0; shift += kDigit) {
    const auto digit = [shift](Slot s) { return static_cast<size_t>(s >> shift & ((1u << kDigit) - 1)); };
    std::array<uint32_t, 1 << kDigit> count{};
    for (Slot s : slots) ++count[digit(s)];
    uint32_t sum = 0;
    for (uint32_t& c : count) c = std::exchange(sum, sum + c);
    for (Slot s : slots) other[count[digit(s)]++] = s;
    slots.swap(other);
  }
}

}  // namespace

bool refine(const TerrainDomain& domain, const StoredNodes& nodes, const View& view, size_t max_nodes,
            RefineScratch& scratch, Section& section, const HiddenBlocks* hidden, ReadableNodes* readable) {
  const Metric metric = domain.metric(view);
  const bool fits = Descent(domain, nodes, metric, scratch, hidden, readable).run(max_nodes);
  if (!fits) return false;
  sortSlots(scratch.slots, scratch.sorted, domain.grid.slotCount());
  section.slots.assign(scratch.slots.begin(), scratch.slots.end());
  return true;
}

SampledSize estimateSize(const TerrainDomain& domain, const StoredNodes& nodes, const View& view, const View& inner,
                         RefineScratch& scratch, const HiddenBlocks* hidden, ReadableNodes* readable) {
  const Metric metric = domain.metric(view);
  return Descent(domain, nodes, metric, scratch, hidden, readable).estimate(domain.metric(inner));
}

size_t countNeeded(const TerrainDomain& domain, const StoredNodes& nodes, const View& view,
                   std::span<const Slot> slots) {
  const Metric metric = domain.metric(view);
  TerrainBatch batch;
  batch.count = 0;
  size_t needed = 0;
  const auto flush = [&] {
    batch.test(domain, metric);
    for (size_t i = 0; i < batch.count; ++i) needed += batch.passes[i];
    batch.count = 0;
  };
  for (Slot slot : slots) {
    const NodeId n = domain.grid.node(slot);
    const int level = domain.grid.level(n);
    batch.setRecord(batch.count, nodes[slot]);
    batch.push(n, slot, level, nodes[slot].error(), domain.spheres.radius(level, nodes[slot].radius()));
    if (batch.full()) flush();
  }
  flush();
  return needed;
}

size_t triangleCount(const GridTopology& grid, const Section& section) {
  const GridShape& shape = grid.shape();
  size_t count = size_t{4} * shape.roots_x * shape.roots_y + section.slots.size();
  for (Slot slot : section.slots) count += grid.apexes(grid.node(slot)).count - 1;
  return count;
}

}  // namespace foreland::proto
