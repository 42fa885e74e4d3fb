#include "proto/refine/terrain_tester.h"

namespace foreland::proto {

namespace {

constexpr QuantisedError kAnyError{255}, kNoError{0};

}  // namespace

void TerrainTester::test() {
  source_.load(batch_);
  batch_.locate(domain_, metric_);
  batch_.testWithSlack(metric_, motion_);
}

bool TerrainTester::decide(int level, std::span<AdaptCandidate> candidates) {
  source_.load(batch_);
  batch_.locate(domain_, metric_);
  batch_.findLeast(metric_);
  if (!askSource(level, candidates)) return false;
  batch_.testWithSlack(metric_, motion_);
  if (memory_.hides) leaveOutHidden(candidates);
  return true;
}

// Nothing is known of the error of a node that is held back, and no motion of the camera changes that it is.
void TerrainTester::leaveOutHidden(std::span<AdaptCandidate> candidates) {
  const auto ask = [&](const BlockId& block) { return source_.isHidden(memory_.blocks, block); };
  for (size_t i = 0; i < candidates.size(); ++i) {
    if (is_held_back_[i] == 0 && (!candidates[i].is_in_section || !memory_.blocks.isHidden(node(i), ask))) continue;
    candidates[i].is_in_section = false;
    batch_.bound[i] = kAnyError;
    batch_.slack[i] = EntryPool::kEndless;
  }
}

// Whether what is known of the error decides. The view may say that no error passes, or that any does.
bool TerrainTester::resolve(size_t i, AdaptCandidate& c) {
  if (batch_.least[i] == TerrainBatch::kNonePasses) {
    if (c.is_in_section) batch_.bound[i] = kAnyError;
    c.is_in_section = false;
    return true;
  }
  const QuantisedError known = batch_.bound[i], least{static_cast<uint8_t>(batch_.least[i])};
  if (least == kNoError) {
    batch_.bound[i] = kNoError;
    c.is_in_section = true;
    return true;
  }
  return c.is_in_section ? known >= least : known < least;
}

// The bounds of the batch are those of the entries from now on.
bool TerrainTester::askSource(int level, std::span<AdaptCandidate> candidates) {
  DecisionScratch& s = scratch_;
  s.predicates.clear();
  s.asked.clear();
  for (size_t i = 0; i < candidates.size(); ++i) {
    AdaptCandidate& c = candidates[i];
    const QuantisedError least{static_cast<uint8_t>(batch_.least[i])};
    s.least.push_back(least);
    is_held_back_[i] = memory_.hides && memory_.blocks.isKnownHidden(node(i)) ? 1 : 0;
    if (is_held_back_[i] != 0) {
      c.is_in_section = false;
      continue;
    }
    if (resolve(i, c)) continue;
    s.predicates.push_back({c.slot, batch_.bound[i], least, c.is_in_section, c.is_new});
    s.asked.push_back(static_cast<uint32_t>(i));
  }
  s.decisions.resize(s.predicates.size());
  if (!s.predicates.empty() && !source_.decide(level, s.predicates, s.decisions)) return false;
  for (size_t k = 0; k < s.asked.size(); ++k) {
    const QuantisedError least = s.predicates[k].least;
    const bool is_at_least = s.decisions[k] != 0;
    candidates[s.asked[k]].is_in_section = is_at_least;
    batch_.bound[s.asked[k]] = is_at_least ? least : QuantisedError{static_cast<uint8_t>(least.value - 1)};
  }
  return true;
}

void TerrainTester::tellAddable(int level, std::span<const AdaptCandidate> candidates) {
  scratch_.slots.clear();
  for (const AdaptCandidate& c : candidates)
    if (c.is_new) scratch_.slots.push_back(c.slot);
  if (!scratch_.slots.empty()) source_.onAddable(level, scratch_.slots);
}

void TerrainTester::endStep(const Frontier::Nodes& nodes, uint32_t steps) {
  constexpr uint32_t kPeriod = 8;
  if (!memory_.hides || steps % kPeriod != 0) return;
  memory_.blocks.retainTiles([&](const BlockId& lowest) { return hasNodesNear(domain_.grid, nodes, lowest); });
}

bool TerrainTester::tellAdded(int level, std::span<const AdaptCandidate> candidates) {
  scratch_.slots.clear();
  scratch_.passed.clear();
  for (size_t i = 0; i < candidates.size(); ++i) {
    if (!candidates[i].is_in_section) continue;
    scratch_.slots.push_back(candidates[i].slot);
    scratch_.passed.push_back(scratch_.least[i]);
  }
  return source_.onAdded(level, scratch_.slots, scratch_.passed);
}

}  // namespace foreland::proto
