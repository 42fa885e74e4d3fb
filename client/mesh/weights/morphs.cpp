#include "client/mesh/weights/morphs.h"

namespace foreland::client {

using proto::Slot;

namespace {

// Of a node that has always been in the section, or never.
uint8_t historyOf(bool is_in) { return is_in ? 0xff : 0; }

}  // namespace

// Merges the nodes still in transition with those that the change starts or reverses, by ascending slot. Nodes whose
// transition is over are dropped.
void Morphs::begin(const proto::CutDelta& change) {
  merged_.clear();
  was_drawn_.clear();
  auto added = change.added.begin(), removed = change.removed.begin();
  const auto start = [&](Slot before) {
    while (true) {
      const bool is_added =
          added != change.added.end() && *added < before && (removed == change.removed.end() || *added < *removed);
      if (!is_added && (removed == change.removed.end() || *removed >= before)) return;
      const double at = is_added ? 0 : 1;
      merged_.push_back({is_added ? *added++ : *removed++, is_added, 0, at, at, historyOf(!is_added)});
      if (!is_added) was_drawn_.push_back(merged_.back().slot);
    }
  };
  for (const Morph& m : all_) {
    start(m.slot);
    const bool in_added = added != change.added.end() && *added == m.slot;
    const bool in_removed = removed != change.removed.end() && *removed == m.slot;
    added += in_added ? 1 : 0;
    removed += in_removed ? 1 : 0;
    DCHECK_TRUE(m.is_added ? !in_added : !in_removed);
    const bool is_added = m.is_added != (in_added || in_removed), was_drawn = (m.in & kInTo) != 0;
    if (m.to == (is_added ? 1 : 0) && was_drawn == is_added) continue;
    merged_.push_back({m.slot, is_added, 0, m.to, m.to, m.history});
    if (was_drawn) was_drawn_.push_back(m.slot);
  }
  start(~Slot{0});
  all_.swap(merged_);
}

// What is left of the way, in equal steps over the intervals that are left for it; or the spline's next part.
void Morphs::advance(Morph& m, double intervals, uint32_t order) {
  const double left = m.goal() - m.from;
  const uint8_t before = m.history;
  m.history = historyOf(m.is_added);
  if (!(intervals > 0)) {
    m.from = m.to = m.goal();
    return;
  }
  if (order > 1) {
    m.history = static_cast<uint8_t>(before << 1 | (m.is_added ? 1 : 0));
    m.to = splineEnd(order, [&m](uint32_t i) { return m.wasIn(i) ? 1.0 : 0.0; });
    return;
  }
  const double steps = std::max(1.0, std::round(std::fabs(left) * intervals));
  m.to = steps > 1 ? m.from + left / steps : m.goal();
}

void Morphs::compare() {
  for (proto::CutDelta* delta : {&jumped_, &drawn_}) delta->added.clear(), delta->removed.clear();
  const auto note = [](proto::CutDelta& delta, Slot slot, bool before, bool after) {
    if (before != after) (after ? delta.added : delta.removed).push_back(slot);
  };
  auto was = was_drawn_.begin();
  for (const Morph& m : all_) {
    const bool was_drawn = was != was_drawn_.end() && *was == m.slot;
    was += was_drawn ? 1 : 0;
    note(jumped_, m.slot, was_drawn, m.in & kInFrom);
    note(drawn_, m.slot, m.in & kInFrom, m.in & kInTo);
  }
}

proto::Section Morphs::sectionOf(proto::Section drawn) const {
  auto m = all_.begin();
  std::erase_if(drawn.slots, [&](Slot slot) {
    while (m != all_.end() && m->slot < slot) ++m;
    return m != all_.end() && m->slot == slot && !m->is_added;
  });
  return drawn;
}

}  // namespace foreland::client
