#include "server/section/adapt.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "server/section/places.h"

namespace foreland::server {

using proto::NodeId;
using proto::Slot;

namespace {

// A step rounds a slack by at most 2^-24 of it. Slacks are kept 2^-9 short, and all entries are tested anew before 2^15 steps
// can use that up.
constexpr double kSlackShare = 1 - 0x1p-9;
constexpr uint32_t kMostSteps = 1u << 15;
constexpr float kForever = 1e9f;

}  // namespace

// One adaptation under way.
template <class Places>
struct Adapter::Step {
  Adapter& a;
  const proto::GridTopology& grid;
  const Metric metric;
  const Places places;
  size_t max_nodes;
  proto::CutDelta& delta;

  Step(Adapter& adapter, const View& view, size_t limit, proto::CutDelta& out)
      : a(adapter),
        grid(adapter.hierarchy_->grid()),
        metric(view, adapter.hierarchy_->hasVerticalErrors()),
        places(*adapter.hierarchy_, metric),
        max_nodes(limit),
        delta(out) {}

  struct Outcome {
    bool passes;
    float slack, reach;
  };

  Outcome test(NodeId n, Slot slot) const {
    const terrain::NodeRecord& record = a.hierarchy_->nodes()[slot];
    ++a.tests_;
    if (record.error.bits == 0) return {false, kForever, 0};
    const Metric::Place p = places(n.x(), n.y(), record.height);
    const double radius = record.radius.metres(), error = record.error.metres();
    const bool passes = metric.passes(p, radius, error);
    const double slack = metric.slack(p, radius, error, passes) * kSlackShare;
    const double distance = std::sqrt(p.x * p.x + p.y * p.y + p.z * p.z);
    return {passes, static_cast<float>(slack), static_cast<float>(std::max(distance, Metric::kNearest_m) + slack)};
  }

  bool isRemovable(NodeId n) const {
    for (NodeId child : grid.children(n))
      if (a.flags_.active(grid.slot(child))) return false;
    return true;
  }
  bool isAddable(NodeId n) const {
    for (NodeId parent : grid.parents(n))
      if (!a.flags_.active(grid.slot(parent))) return false;
    return true;
  }

  void list(Slot slot, const Outcome& outcome) {
    a.flags_.setListed(slot, true);
    a.slots_.push_back(slot);
    a.slack_.push_back(outcome.slack);
    a.reach_.push_back(outcome.reach);
  }

  // A frontier node without an entry: test it, list it, and change it if it is not as it should be.
  void consider(NodeId n) {
    const Slot slot = grid.slot(n);
    if (a.flags_.listed(slot)) return;  // its entry vouches for it, or is due in this very step
    const Outcome outcome = test(n, slot);
    list(slot, outcome);
    if (outcome.passes != a.flags_.active(slot)) change(slot, outcome.passes);
  }

  void change(Slot slot, bool active) {
    if (active && a.active_ >= max_nodes) return;
    a.flags_.setActive(slot, active);
    a.active_ += active ? 1 : -1;
    (active ? delta.added : delta.removed).push_back(slot);
    a.queue_.push_back(slot);
  }

  // After a change: children may have become addable, or parents removable.
  void spread(Slot slot) {
    const NodeId n = grid.node(slot);
    if (a.flags_.active(slot)) {
      for (NodeId child : grid.children(n))
        if (isAddable(child)) consider(child);
    } else {
      for (NodeId parent : grid.parents(n))
        if (isRemovable(parent)) consider(parent);
    }
  }

  // Tests an entry whose slack is used up. False if its node has left the frontier and the entry should go.
  bool retest(uint32_t entry) {
    const Slot slot = a.slots_[entry];
    const NodeId n = grid.node(slot);
    const bool active = a.flags_.active(slot);
    if (active ? !isRemovable(n) : !isAddable(n)) return false;
    const Outcome outcome = test(n, slot);
    a.slack_[entry] = outcome.slack;
    a.reach_[entry] = outcome.reach;
    if (outcome.passes != active) change(slot, outcome.passes);
    return true;
  }

  void drain() {
    while (!a.queue_.empty()) {
      const Slot slot = a.queue_.back();
      a.queue_.pop_back();
      spread(slot);
    }
  }
};

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
  // A tolerance q times as large acts like depths q times as large (metric.cpp).
  const double turned = turnBetween(last_->pose.orientation, view.pose.orientation) +
                        std::fabs(view.turn_rad - last_->turn_rad) + std::fabs(std::expm1(std::log(view.tau_px / last_->tau_px)));
  per_metre = static_cast<float>(turned * 1.00001);
  return static_cast<float>(moved * 1.00001 + 1e-6);
}

template <class Places>
bool Adapter::run(const View& view, size_t max_nodes, proto::CutDelta& delta) {
  ++steps_;
  float per_metre;
  const float moved = motionSince(view, per_metre);
  const bool first = !last_;
  Step<Places> step(*this, view, max_nodes, delta);
  last_ = view;
  if (first) {
    const proto::GridTopology& grid = hierarchy_->grid();
    const uint32_t size = grid.rootSize(), half = size / 2;
    for (uint32_t y = 0; y <= grid.maxY(); y += half)
      for (uint32_t x = (y / half) % 2 == 0 ? half : 0; x <= grid.maxX(); x += size) step.consider(NodeId::at(x, y));
  }

  due_.clear();
  const size_t count = slots_.size();
  due_.resize(count);
  float* slack = slack_.data();
  const float* reach = reach_.data();
  for (size_t i = 0; i < count; ++i) slack[i] -= moved + per_metre * reach[i];
  size_t due_count = 0;
  for (size_t i = 0; i < count; ++i) {
    due_[due_count] = static_cast<uint32_t>(i);
    due_count += slack[i] <= 0 ? 1 : 0;
  }
  due_.resize(due_count);

  // First all entries that are due get their new outcome, then changes spread; entries that left the frontier go last, from the
  // end, so that places of those before them hold.
  size_t dropped = 0;
  for (uint32_t entry : due_)
    if (!step.retest(entry)) due_[dropped++] = entry;
  step.drain();
  // An entry marked to go may be back on the frontier through what spread; it is then tested like a new one.
  for (size_t i = dropped; i-- > 0;) {
    const uint32_t entry = due_[i];
    flags_.setListed(slots_[entry], false);
    queue_.push_back(slots_[entry]);
    slots_[entry] = slots_.back();
    slack_[entry] = slack_.back();
    reach_[entry] = reach_.back();
    slots_.pop_back();
    slack_.pop_back();
    reach_.pop_back();
  }
  std::vector<Slot>& gone = due_;
  gone.assign(queue_.begin(), queue_.end());
  queue_.clear();
  for (Slot slot : gone) {
    const NodeId n = hierarchy_->grid().node(slot);
    if (flags_.active(slot) ? step.isRemovable(n) : step.isAddable(n)) step.consider(n);
    step.drain();
  }
  if (active_ < max_nodes) return true;
  last_->tau_px = 0;  // every outcome is in doubt: the next view is compared with nothing
  last_->lens.width_px = 0;
  return false;
}

bool Adapter::adapt(const View& view, size_t max_nodes, proto::CutDelta& delta) {
  return hierarchy_->hasVerticalErrors() ? run<PlanarPlaces>(view, max_nodes, delta) : run<CurvedPlaces>(view, max_nodes, delta);
}

proto::Section Adapter::section() const {
  proto::Section section;
  section.slots.reserve(active_);
  flags_.forEachActive([&](Slot slot) { section.slots.push_back(slot); });
  std::sort(section.slots.begin(), section.slots.end());
  return section;
}

size_t Adapter::bytes() const {
  return flags_.bytes() + slots_.capacity() * (sizeof(Slot) + 2 * sizeof(float)) + due_.capacity() * sizeof(uint32_t) +
         queue_.capacity() * sizeof(Slot);
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
