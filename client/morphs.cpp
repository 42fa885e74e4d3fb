#include "client/morphs.h"

namespace foreland::client {

using proto::Slot;

// Those that are still on their way, with those that set out or turn round; what has come or gone is left out.
void Morphs::begin(const proto::CutDelta& change) {
  merged_.clear();
  was_drawn_.clear();
  auto added = change.added.begin(), removed = change.removed.begin();
  const auto setOut = [&](Slot before) {
    while (true) {
      const bool comes =
          added != change.added.end() && *added < before && (removed == change.removed.end() || *added < *removed);
      if (!comes && (removed == change.removed.end() || *removed >= before)) return;
      const double at = comes ? 0 : 1;
      merged_.push_back({comes ? *added++ : *removed++, comes, 0, at, at});
      if (!comes) was_drawn_.push_back(merged_.back().slot);
    }
  };
  for (const Morph& m : all_) {
    setOut(m.slot);
    const bool is_added = added != change.added.end() && *added == m.slot;
    const bool is_removed = removed != change.removed.end() && *removed == m.slot;
    added += is_added ? 1 : 0;
    removed += is_removed ? 1 : 0;
    DCHECK_TRUE(m.comes ? !is_added : !is_removed);
    const bool comes = m.comes != (is_added || is_removed), was_drawn = (m.in & kInTo) != 0;
    if (m.to == (comes ? 1 : 0) && was_drawn == comes) continue;
    merged_.push_back({m.slot, comes, 0, m.to, m.to});
    if (was_drawn) was_drawn_.push_back(m.slot);
  }
  setOut(~Slot{0});
  all_.swap(merged_);
}

// In equal parts, as many as the clock has left.
void Morphs::advance(Morph& m, double intervals) {
  const double left = m.goal() - m.from;
  if (!(intervals > 0)) {
    m.from = m.to = m.goal();
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
    return m != all_.end() && m->slot == slot && !m->comes;
  });
  return drawn;
}

}  // namespace foreland::client
