#include "server/section/adapt.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>

#include "server/section/batch.h"
#include "server/section/places.h"

namespace foreland::server {

using proto::NodeId;
using proto::Slot;

namespace {

// A step rounds a slack by at most 2^-24 of it. Slacks are kept 2^-9 short, and all entries are tested anew before 2^15
// steps can use that up.
constexpr double kSlackShare = 1 - 0x1p-9;
constexpr uint32_t kMostSteps = 1u << 15;

}  // namespace

namespace {

constexpr uint32_t kGuardBits = 3;

uint32_t packReach(float reach, uint8_t guard) {
  return (std::bit_cast<uint32_t>(reach * (1 + 0x1p-20f)) & ~kGuardBits) | guard;
}
bool saysPasses(uint32_t packed) { return (packed & kGuardBits) == static_cast<uint32_t>(Metric::Guard::kPasses); }

}  // namespace

// Endless if the views cannot be compared.
Metric::Toll Adapter::tollTo(const View& view) const {
  if (last_ && last_->lens == view.lens && steps_ % kMostSteps != 0)
    return Metric(*last_, hierarchy_->hasVerticalErrors()).tollTo(*last_, view);
  constexpr double kEndless = std::numeric_limits<double>::infinity();
  return {{kEndless, kEndless, kEndless}, {0, 0, 0}};
}

// One adaptation under way.
template <class Places>
class Adapter::Step {
 public:
  Step(Adapter& adapter, const View& view, size_t max_nodes, AdaptScratch& scratch, proto::CutDelta& delta)
      : a_(adapter),
        grid_(adapter.hierarchy_->grid()),
        nodes_(adapter.hierarchy_->nodes().data()),
        metric_(view, adapter.hierarchy_->hasVerticalErrors()),
        places_(*adapter.hierarchy_, metric_),
        max_nodes_(max_nodes),
        scratch_(scratch),
        delta_(delta) {
    scratch_.changed.clear();
    scratch_.left.clear();
    batch_.count = 0;
  }

  bool run(const Metric::Toll& toll, bool first) {
    if (first) considerRoots();
    takeOff(toll);
    testDue();
    spreadAll();
    sweep();
    dropLeft();
    return !limited_;
  }

 private:
  bool isActive(NodeId n) const { return a_.flags_.get(NodeFlags::kActive, grid_.slot(n)); }
  template <class Nodes>
  bool anyActive(const Nodes& nodes) const {
    for (NodeId n : nodes)
      if (isActive(n)) return true;
    return false;
  }
  template <class Nodes>
  bool allActive(const Nodes& nodes) const {
    for (NodeId n : nodes)
      if (!isActive(n)) return false;
    return true;
  }

  // The nodes without parents.
  void considerRoots() {
    const uint32_t size = grid_.rootSize(), half = size / 2;
    for (uint32_t y = 0; y <= grid_.maxY(); y += half)
      for (uint32_t x = (y / half) % 2 == 0 ? half : 0; x <= grid_.maxX(); x += size)
        consider(NodeId::at(x, y), grid_.slot(NodeId::at(x, y)), 0);
    spreadAll();
  }

  void takeOff(const Metric::Toll& toll) {
    const size_t count = a_.slots_.size();
    float* slack = a_.slack_.data();
    const uint32_t* reach = a_.reach_.data();
    const float f0 = static_cast<float>(toll.fixed[0]), f1 = static_cast<float>(toll.fixed[1]),
                f2 = static_cast<float>(toll.fixed[2]);
    const float r0 = static_cast<float>(toll.per_reach[0]), r1 = static_cast<float>(toll.per_reach[1]),
                r2 = static_cast<float>(toll.per_reach[2]);
    for (size_t i = 0; i < count; ++i) {
      const uint32_t guard = reach[i] & kGuardBits;
      const float fixed = guard == 0 ? f0 : guard == 1 ? f1 : f2, per_reach = guard == 0 ? r0 : guard == 1 ? r1 : r2;
      slack[i] -= fixed + per_reach * std::bit_cast<float>(reach[i]);
    }
    scratch_.due.resize(count);
    uint32_t* due = scratch_.due.data();
    size_t due_count = 0;
    for (size_t i = 0; i < count; ++i) {
      due[due_count] = static_cast<uint32_t>(i);
      due_count += slack[i] <= 0 ? 1 : 0;
    }
    scratch_.due.resize(due_count);
  }

  void testDue() {
    const std::vector<uint32_t>& due = scratch_.due;
    constexpr size_t kAhead = 24;
    for (size_t begin = 0; begin < due.size(); begin += Batch::kSize) {
      const size_t count = std::min(Batch::kSize, due.size() - begin);
      for (size_t i = 0; i < count; ++i) {
        if (begin + i + kAhead < due.size()) __builtin_prefetch(&nodes_[a_.slots_[due[begin + i + kAhead]]]);
        put(i, a_.slots_[due[begin + i]]);
      }
      batch_.count = count;
      testBatch();
      for (size_t i = 0; i < count; ++i) update(due[begin + i], i);
    }
    batch_.count = 0;
  }

  void put(size_t i, Slot slot) {
    const NodeId n = grid_.node(slot);
    batch_.slot[i] = slot;
    batch_.x[i] = static_cast<int32_t>(n.x());
    batch_.y[i] = static_cast<int32_t>(n.y());
  }

  void testBatch() {
    batch_.load(nodes_);
    batch_.testWithSlack(metric_, places_, kSlackShare);
    a_.tests_ += batch_.count;
  }

  // An entry that was due gets its new outcome. If that is not what the node is, the node changes. If it has left the
  // frontier, its neighbours are about to change first, and will find it without an entry.
  void update(uint32_t entry, size_t i) {
    const Slot slot = batch_.slot[i];
    const bool was = saysPasses(a_.reach_[entry]);
    const bool is = batch_.guard[i] == static_cast<uint8_t>(Metric::Guard::kPasses);
    if (was != is && a_.flags_.get(NodeFlags::kLeft, slot)) return drop(entry);
    if (was != is && !change(slot, is)) return;  // stays due
    a_.slack_[entry] = batch_.slack[i];
    a_.reach_[entry] = packReach(batch_.reach[i], batch_.guard[i]);
  }

  // The entry goes at the end of the step; from now on nothing vouches for its node.
  void drop(uint32_t entry) {
    a_.flags_.set(NodeFlags::kListed, a_.slots_[entry], false);
    a_.flags_.set(NodeFlags::kLeft, a_.slots_[entry], false);
    a_.slots_[entry] = proto::kNoSlot;
    scratch_.left.push_back(entry);
  }

  // False if the section may not grow any more.
  bool change(Slot slot, bool active) {
    if (active && a_.active_ >= max_nodes_) {
      limited_ = true;
      return false;
    }
    a_.flags_.set(NodeFlags::kActive, slot, active);
    a_.active_ += active ? 1 : -1;
    (active ? delta_.added : delta_.removed).push_back(slot);
    scratch_.changed.push_back(slot);
    return true;
  }

  // A frontier node: if no entry vouches for it, it is tested with the next batch and gets one.
  void consider(NodeId n, Slot slot, uint32_t flags) {
    if (flags & kIsListed) return a_.flags_.set(NodeFlags::kLeft, slot, false);
    a_.flags_.set(NodeFlags::kListed, slot, true);
    __builtin_prefetch(&nodes_[slot]);
    batch_.slot[batch_.count] = slot;
    batch_.x[batch_.count] = static_cast<int32_t>(n.x());
    batch_.y[batch_.count++] = static_cast<int32_t>(n.y());
    if (batch_.full()) listBatch();
  }

  void listBatch() {
    testBatch();
    for (size_t i = 0; i < batch_.count; ++i) {
      const Slot slot = batch_.slot[i];
      uint32_t reach = packReach(batch_.reach[i], batch_.guard[i]);
      float slack = batch_.slack[i];
      if (saysPasses(reach) != a_.flags_.get(NodeFlags::kActive, slot) && !change(slot, saysPasses(reach)))
        reach = packReach(batch_.reach[i], 0), slack = 0;
      append(a_.slots_, slot);
      append(a_.slack_, slack);
      append(a_.reach_, reach);
    }
    batch_.count = 0;
  }

  // Grows by an eighth, for a session's memory is counted.
  template <class T>
  static void append(std::vector<T>& column, T value) {
    if (column.size() == column.capacity()) column.reserve(column.size() + column.size() / 8 + 1024);
    column.push_back(value);
  }

  // After a change its own entry holds; neighbours may have come to the frontier or left it.
  void spreadAll() {
    while (!scratch_.changed.empty() || batch_.count > 0) {
      if (scratch_.changed.empty()) listBatch();
      if (scratch_.changed.empty()) continue;
      const Slot slot = scratch_.changed.back();
      scratch_.changed.pop_back();
      if (a_.flags_.get(NodeFlags::kActive, slot))
        spreadAdded(grid_.node(slot));
      else
        spreadRemoved(grid_.node(slot));
    }
  }

  static constexpr uint32_t kIsActive = 1u << NodeFlags::kActive, kIsListed = 1u << NodeFlags::kListed,
                            kHasLeft = 1u << NodeFlags::kLeft;
  static bool isVouchedFor(uint32_t flags) { return (flags & (kIsListed | kHasLeft)) == kIsListed; }

  void spreadAdded(NodeId n) {
    for (NodeId parent : grid_.parents(n)) a_.flags_.leaveIfListed(grid_.slot(parent));
    for (NodeId child : grid_.children(n)) {
      const Slot slot = grid_.slot(child);
      const uint32_t flags = a_.flags_.all(slot);
      if (!(flags & kIsActive) && !isVouchedFor(flags) && allActive(grid_.parents(child))) consider(child, slot, flags);
    }
  }

  void spreadRemoved(NodeId n) {
    for (NodeId child : grid_.children(n)) a_.flags_.leaveIfListed(grid_.slot(child));
    for (NodeId parent : grid_.parents(n)) {
      const Slot slot = grid_.slot(parent);
      const uint32_t flags = a_.flags_.all(slot);
      if ((flags & kIsActive) && !isVouchedFor(flags) && !anyActive(grid_.children(parent)))
        consider(parent, slot, flags);
    }
  }

  // A share of the entries at each step, in turn: those that have left the frontier go, so that they do not pile up.
  void sweep() {
    constexpr size_t kShare = 8;
    for (size_t todo = a_.slots_.size() / kShare; todo > 0; --todo) {
      if (++a_.sweep_ >= a_.slots_.size()) a_.sweep_ = 0;
      if (a_.flags_.get(NodeFlags::kLeft, a_.slots_[a_.sweep_])) drop(static_cast<uint32_t>(a_.sweep_));
    }
  }

  // From the end, so that the places of those before hold.
  void dropLeft() {
    std::vector<uint32_t>& left = scratch_.left;
    std::sort(left.begin(), left.end());
    for (size_t i = left.size(); i-- > 0;) {
      const uint32_t entry = left[i];
      const auto remove = [entry](auto& column) {
        column[entry] = column.back();
        column.pop_back();
      };
      remove(a_.slots_);
      remove(a_.slack_);
      remove(a_.reach_);
    }
  }

  Adapter& a_;
  const proto::GridTopology& grid_;
  const terrain::NodeRecord* nodes_;
  const Metric metric_;
  const Places places_;
  const size_t max_nodes_;
  AdaptScratch& scratch_;
  proto::CutDelta& delta_;
  Batch batch_;
  bool limited_ = false;
};

bool Adapter::adapt(const View& view, size_t max_nodes, AdaptScratch& scratch, proto::CutDelta& delta) {
  ++steps_;
  const Metric::Toll toll = tollTo(view);
  const bool first = !last_;
  last_ = view;
  const bool complete = hierarchy_->isPlanar()
                            ? Step<PlanarPlaces>(*this, view, max_nodes, scratch, delta).run(toll, first)
                            : Step<CurvedPlaces>(*this, view, max_nodes, scratch, delta).run(toll, first);
  if (!complete) last_->lens.width_px = 0;  // every outcome is in doubt: the next view is compared with nothing
  // The very first step lists far more than the steps after it.
  if (slots_.capacity() > slots_.size() + slots_.size() / 2 + 8192)
    slots_.shrink_to_fit(), slack_.shrink_to_fit(), reach_.shrink_to_fit();
  return complete;
}

proto::Section Adapter::section() const {
  proto::Section section;
  section.slots.reserve(active_);
  flags_.forEachActive([&](Slot slot) { section.slots.push_back(slot); });
  std::sort(section.slots.begin(), section.slots.end());
  return section;
}

size_t Adapter::bytes() const {
  return flags_.bytes() + slots_.capacity() * sizeof(Slot) + slack_.capacity() * sizeof(float) +
         reach_.capacity() * sizeof(uint32_t);
}

void Adapter::validate() const {
  const proto::GridTopology& grid = hierarchy_->grid();
  const auto active = [&](NodeId n) { return flags_.get(NodeFlags::kActive, grid.slot(n)); };
  size_t listed = 0;
  for (Slot slot = 0; slot < grid.slotCount(); ++slot) {
    const NodeId n = grid.node(slot);
    if (grid.isBase(n)) continue;
    const auto parents = grid.parents(n);
    const auto children = grid.children(n);
    const bool rooted = std::all_of(parents.begin(), parents.end(), active),
               leaf = std::none_of(children.begin(), children.end(), active);
    if (active(n)) CHECK_TRUE(rooted);
    listed += flags_.get(NodeFlags::kListed, slot);
    CHECK_EQ(active(n) ? leaf : rooted, flags_.get(NodeFlags::kListed, slot) && !flags_.get(NodeFlags::kLeft, slot));
  }
  CHECK_EQ(listed, slots_.size());
}

void settle(proto::CutDelta& delta) {
  std::sort(delta.added.begin(), delta.added.end());
  std::sort(delta.removed.begin(), delta.removed.end());
  std::vector<Slot> both;
  std::set_intersection(delta.added.begin(), delta.added.end(), delta.removed.begin(), delta.removed.end(),
                        std::back_inserter(both));
  if (both.empty()) return;
  const auto drop = [&](std::vector<Slot>& slots) {
    std::erase_if(slots, [&](Slot s) { return std::binary_search(both.begin(), both.end(), s); });
  };
  drop(delta.added);
  drop(delta.removed);
}

}  // namespace foreland::server
