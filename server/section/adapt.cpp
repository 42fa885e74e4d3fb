#include "server/section/adapt.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "server/section/batch.h"
#include "server/section/places.h"

namespace foreland::server {

using proto::NodeId;
using proto::Slot;

namespace {

// A step rounds a slack by at most 2^-24 of it. Slacks are kept 2^-9 short, and all entries are tested anew before 2^15 steps
// can use that up.
constexpr double kSlackShare = 1 - 0x1p-9;
constexpr uint32_t kMostSteps = 1u << 15;

}  // namespace

namespace {

// Angle between two orientations, rounded up.
double turnBetween(const glm::dquat& a, const glm::dquat& b) {
  const glm::dquat d = glm::conjugate(a) * b;
  return 2 * std::asin(std::min(1.0, std::sqrt(d.x * d.x + d.y * d.y + d.z * d.z))) * (1 + 1e-12) + 1e-15;
}

}  // namespace

// Upper bound of how far a place at distance `reach` moves between the last view and this one: the return value plus
// per_metre * reach. Infinite if the views cannot be compared.
float Adapter::motionSince(const View& view, float& per_metre) const {
  per_metre = 0;
  if (!last_ || !(last_->lens == view.lens) || steps_ % kMostSteps == 0) return std::numeric_limits<float>::infinity();
  const double moved = glm::distance(last_->pose.eye, view.pose.eye) + std::fabs(view.ball_m - last_->ball_m);
  // A tolerance q times as large acts like depths q times as large: z < K / q is q z < K, and z^2 < K h / q is implied by
  // (q z)^2 < K h for q > 1, and the other way round for q < 1.
  const double turned = turnBetween(last_->pose.orientation, view.pose.orientation) +
                        std::fabs(view.turn_rad - last_->turn_rad) + std::fabs(view.tau_px / last_->tau_px - 1);
  per_metre = static_cast<float>(turned * 1.00001);
  return static_cast<float>(moved * 1.00001 + 1e-6);
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
    scratch_.returning.clear();
    batch_.count = 0;
  }

  bool run(float moved, float per_metre, bool first) {
    if (first) considerRoots();
    takeOff(moved, per_metre);
    testDue();
    spreadAll();
    sweep();
    dropLeft();
    for (Slot slot : scratch_.returning) {
      const NodeId n = grid_.node(slot);
      if (a_.flags_.active(slot) ? isRemovable(n) : isAddable(n)) consider(n);
    }
    spreadAll();
    return !limited_;
  }

 private:
  bool isRemovable(NodeId n) const {
    for (NodeId child : grid_.children(n))
      if (a_.flags_.active(grid_.slot(child))) return false;
    return true;
  }
  bool isAddable(NodeId n) const {
    for (NodeId parent : grid_.parents(n))
      if (!a_.flags_.active(grid_.slot(parent))) return false;
    return true;
  }
  bool isOnFrontier(Slot slot) const {
    const NodeId n = grid_.node(slot);
    return a_.flags_.active(slot) ? isRemovable(n) : isAddable(n);
  }

  // The nodes without parents.
  void considerRoots() {
    const uint32_t size = grid_.rootSize(), half = size / 2;
    for (uint32_t y = 0; y <= grid_.maxY(); y += half)
      for (uint32_t x = (y / half) % 2 == 0 ? half : 0; x <= grid_.maxX(); x += size) consider(NodeId::at(x, y));
    spreadAll();
  }

  void takeOff(float moved, float per_metre) {
    const size_t count = a_.slots_.size();
    float* slack = a_.slack_.data();
    const float* reach = a_.reach_.data();
    for (size_t i = 0; i < count; ++i) slack[i] -= moved + per_metre * std::fabs(reach[i]);
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

  // An entry that was due gets its new outcome. If that differs from what the node is, the node changes; should it not be on the
  // frontier, its neighbours are about to change too: it is looked at again when they have.
  void update(uint32_t entry, size_t i) {
    const Slot slot = batch_.slot[i];
    const bool was = std::signbit(a_.reach_[entry]), is = batch_.passes[i];
    if (was != is ? !isOnFrontier(slot) || !change(slot, is) : isTurnToCheck(entry) && !isOnFrontier(slot)) {
      scratch_.left.push_back(entry);
      return;
    }
    a_.slack_[entry] = batch_.slack[i];
    a_.reach_[entry] = is ? -batch_.reach[i] : batch_.reach[i];
  }

  // Looking whether a node is still on the frontier costs more than its test, so it is done at one test in four.
  bool isTurnToCheck(uint32_t entry) const { return ((entry ^ a_.steps_) & 3) == 0; }

  // False if the section may not grow any more.
  bool change(Slot slot, bool active) {
    if (active && a_.active_ >= max_nodes_) {
      limited_ = true;
      return false;
    }
    a_.flags_.setActive(slot, active);
    a_.active_ += active ? 1 : -1;
    (active ? delta_.added : delta_.removed).push_back(slot);
    scratch_.changed.push_back(slot);
    return true;
  }

  // A frontier node: if no entry vouches for it, it is tested with the next batch and gets one.
  void consider(NodeId n) {
    const Slot slot = grid_.slot(n);
    if (a_.flags_.listed(slot)) return;
    a_.flags_.setListed(slot, true);
    batch_.slot[batch_.count] = slot;
    batch_.x[batch_.count] = static_cast<int32_t>(n.x());
    batch_.y[batch_.count++] = static_cast<int32_t>(n.y());
    if (batch_.full()) listBatch();
  }

  void listBatch() {
    testBatch();
    for (size_t i = 0; i < batch_.count; ++i) {
      const Slot slot = batch_.slot[i];
      bool is = batch_.passes[i];
      float slack = batch_.slack[i];
      if (is != a_.flags_.active(slot) && !change(slot, is)) is = false, slack = 0;
      append(a_.slots_, slot);
      append(a_.slack_, slack);
      append(a_.reach_, is ? -batch_.reach[i] : batch_.reach[i]);
    }
    batch_.count = 0;
  }

  // Grows by an eighth, for a session's memory is counted.
  template <class T>
  static void append(std::vector<T>& column, T value) {
    if (column.size() == column.capacity()) column.reserve(column.size() + column.size() / 8 + 1024);
    column.push_back(value);
  }

  // After a change children may have become addable, or parents removable.
  void spreadAll() {
    while (!scratch_.changed.empty() || batch_.count > 0) {
      if (scratch_.changed.empty()) listBatch();
      if (scratch_.changed.empty()) continue;
      const Slot slot = scratch_.changed.back();
      scratch_.changed.pop_back();
      const NodeId n = grid_.node(slot);
      if (a_.flags_.active(slot)) {
        for (NodeId child : grid_.children(n))
          if (isAddable(child)) consider(child);
      } else {
        for (NodeId parent : grid_.parents(n))
          if (isRemovable(parent)) consider(parent);
      }
    }
  }

  // A share of the entries at each step, in turn: those of nodes that have left the frontier go, so that they do not pile up.
  void sweep() {
    constexpr size_t kShare = 64;
    size_t todo = a_.slots_.size() / kShare + 1;
    if (a_.sweep_ >= a_.slots_.size()) a_.sweep_ = 0;
    for (; todo > 0 && a_.sweep_ < a_.slots_.size(); --todo, ++a_.sweep_)
      if (!isOnFrontier(a_.slots_[a_.sweep_])) scratch_.left.push_back(static_cast<uint32_t>(a_.sweep_));
  }

  // From the end, so that the places of those before hold.
  void dropLeft() {
    std::vector<uint32_t>& left = scratch_.left;
    std::sort(left.begin(), left.end());
    left.erase(std::unique(left.begin(), left.end()), left.end());
    for (size_t i = left.size(); i-- > 0;) {
      const uint32_t entry = left[i];
      a_.flags_.setListed(a_.slots_[entry], false);
      scratch_.returning.push_back(a_.slots_[entry]);
      const auto drop = [entry](auto& column) {
        column[entry] = column.back();
        column.pop_back();
      };
      drop(a_.slots_);
      drop(a_.slack_);
      drop(a_.reach_);
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
  float per_metre;
  const float moved = motionSince(view, per_metre);
  const bool first = !last_;
  last_ = view;
  const bool complete = hierarchy_->isPlanar() ? Step<PlanarPlaces>(*this, view, max_nodes, scratch, delta).run(moved, per_metre, first)
                                               : Step<CurvedPlaces>(*this, view, max_nodes, scratch, delta).run(moved, per_metre, first);
  if (!complete) last_->lens.width_px = 0;  // every outcome is in doubt: the next view is compared with nothing
  // The very first step lists far more than the steps after it.
  if (slots_.capacity() > 2 * slots_.size() + 8192)
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
  return flags_.bytes() + slots_.capacity() * sizeof(Slot) + slack_.capacity() * sizeof(float) + reach_.capacity() * sizeof(float);
}

void settle(proto::CutDelta& delta) {
  std::sort(delta.added.begin(), delta.added.end());
  std::sort(delta.removed.begin(), delta.removed.end());
  std::vector<Slot> both;
  std::set_intersection(delta.added.begin(), delta.added.end(), delta.removed.begin(), delta.removed.end(), std::back_inserter(both));
  if (both.empty()) return;
  const auto drop = [&](std::vector<Slot>& slots) {
    std::erase_if(slots, [&](Slot s) { return std::binary_search(both.begin(), both.end(), s); });
  };
  drop(delta.added);
  drop(delta.removed);
}

}  // namespace foreland::server
