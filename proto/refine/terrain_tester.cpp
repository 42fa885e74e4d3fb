#include "proto/refine/terrain_tester.h"

namespace foreland::proto {

namespace {

constexpr QuantisedError kLeastError{1}, kAnyError{255};

}  // namespace

void TerrainTester::test() {
  source_.load(batch_);
  batch_.locate(domain_, metric_);
  batch_.testWithSlack(metric_, motion_);
}

// A node that is known had an error of at least some `least` once, which its page has noted as `finest` if it was none
// finer. What else was known of the error of a node that comes to the frontier has been forgotten.
void TerrainTester::setBounds(std::span<const AdaptCandidate> candidates, const Frontier::Nodes& nodes) {
  for (size_t i = 0; i < candidates.size(); ++i) {
    const AdaptCandidate& c = candidates[i];
    if (c.is_settled)
      batch_.bound[i] = batch_.recorded[i];
    else if (c.is_in_section && batch_.bound[i] == kLeastError)
      batch_.bound[i] = std::max(kLeastError, nodes.page(c.page).knowledge.finest);
  }
}

bool TerrainTester::decide(int level, std::span<AdaptCandidate> candidates, Frontier& frontier) {
  source_.load(batch_);
  setBounds(candidates, frontier.nodes());
  batch_.locate(domain_, metric_);
  batch_.findLeast(metric_);
  if (!askSource(level, candidates, frontier)) return false;
  if (memory_.hides) leaveOutHidden(candidates);
  if (!tellAdded(level, candidates)) return false;
  settle(candidates, frontier);
  batch_.testWithSlack(metric_, motion_);
  // No motion of the camera changes that a block is hidden.
  for (size_t i = 0; memory_.hides && i < candidates.size(); ++i)
    if (is_hidden_[i] != 0) batch_.slack[i] = EntryPool::kEndless;
  return true;
}

// Nothing is known of the error of a node that is held back, unless it was told.
void TerrainTester::leaveOutHidden(std::span<AdaptCandidate> candidates) {
  const auto ask = [&](const BlockId& block) { return source_.isHidden(memory_.blocks, block); };
  for (size_t i = 0; i < candidates.size(); ++i) {
    if (is_hidden_[i] == 0 && (!candidates[i].is_in_section || !memory_.blocks.isHidden(node(i), ask))) continue;
    is_hidden_[i] = 1;
    candidates[i].is_in_section = false;
    if (!candidates[i].is_settled) batch_.bound[i] = kAnyError;
  }
}

// Whether what is known of the error decides. The view may say that no error passes; of a node that is known but whose
// error is not, all that is known is that it was asked about.
bool TerrainTester::resolve(size_t i, AdaptCandidate& c, QuantisedError finest) {
  if (c.is_new && c.is_known && !c.is_in_section && !c.is_settled && finest.value >= batch_.least[i]) {
    batch_.bound[i] = finest;
    c.is_in_section = true;
    return true;
  }
  const bool passes = batch_.bound[i].value >= batch_.least[i];
  const bool is_decided =
      c.is_settled || batch_.least[i] == TerrainBatch::kNonePasses || (c.is_in_section ? passes : !passes);
  if (is_decided && c.is_in_section && !passes && !c.is_settled) batch_.bound[i] = kAnyError;
  if (is_decided) c.is_in_section = passes;
  return is_decided;
}

Familiarity TerrainTester::familiarityOf(size_t i, int level, const AdaptCandidate& c, QuantisedError least,
                                         const Frontier::Nodes& nodes) const {
  if (c.is_known) return Familiarity::kKnown;
  for (NodeId parent : domain_.grid.parents(node(i), level)) {
    const Slot above = domain_.grid.slot(parent, level - 1);
    if (!nodes.pageAt(above).knowledge.known.has(lowOf(above))) return Familiarity::kNew;
  }
  return nodes.page(c.page).knowledge.finest > least ? Familiarity::kSeen : Familiarity::kRejected;
}

void TerrainTester::collectPredicates(int level, std::span<AdaptCandidate> candidates, const Frontier::Nodes& nodes) {
  DecisionScratch& s = scratch_;
  s.predicates.clear();
  s.asked.clear();
  for (size_t i = 0; i < candidates.size(); ++i) {
    AdaptCandidate& c = candidates[i];
    is_hidden_[i] = memory_.hides && memory_.blocks.isKnownHidden(node(i)) ? 1 : 0;
    if (is_hidden_[i] != 0 || resolve(i, c, nodes.page(c.page).knowledge.finest)) continue;
    const QuantisedError least{static_cast<uint8_t>(batch_.least[i])};
    const Familiarity familiarity =
        c.is_new && !c.is_in_section ? familiarityOf(i, level, c, least, nodes) : Familiarity::kNew;
    s.predicates.push_back({.slot = c.slot,
                            .bound = batch_.bound[i],
                            .least = least,
                            .is_in_section = c.is_in_section,
                            .is_new = c.is_new,
                            .is_known = c.is_known,
                            .familiarity = familiarity,
                            .finest = nodes.page(c.page).knowledge.finest});
    s.asked.push_back(static_cast<uint32_t>(i));
  }
}

bool TerrainTester::askSource(int level, std::span<AdaptCandidate> candidates, Frontier& frontier) {
  collectPredicates(level, candidates, frontier.nodes());
  DecisionScratch& s = scratch_;
  s.decisions.resize(s.predicates.size());
  if (!s.predicates.empty() && !source_.decide(level, s.predicates, s.decisions)) return false;
  for (size_t k = 0; k < s.asked.size(); ++k) {
    AdaptCandidate& c = candidates[s.asked[k]];
    const QuantisedError least = s.predicates[k].least;
    c.is_in_section = s.decisions[k] != 0;
    batch_.bound[s.asked[k]] = c.is_in_section ? least : QuantisedError{static_cast<uint8_t>(least.value - 1)};
    frontier.noteDecision(c.page, least);
  }
  return true;
}

bool TerrainTester::tellAdded(int level, std::span<const AdaptCandidate> candidates) {
  DecisionScratch& s = scratch_;
  s.added.clear();
  for (size_t k = 0; k < s.asked.size(); ++k)
    if (!s.predicates[k].is_known && candidates[s.asked[k]].is_in_section) s.added.push_back(s.predicates[k]);
  return s.added.empty() || source_.onAdded(level, s.added);
}

// Notes the errors that a decision and what was known before leave no doubt about.
void TerrainTester::settle(std::span<const AdaptCandidate> candidates, Frontier& frontier) {
  const DecisionScratch& s = scratch_;
  for (size_t k = 0; k < s.asked.size(); ++k) {
    const Predicate& q = s.predicates[k];
    const uint32_t i = s.asked[k];
    const AdaptCandidate& c = candidates[i];
    if (is_hidden_[i] != 0 || (!q.is_known && !c.is_in_section)) continue;
    const bool is_true = s.decisions[k] != 0;
    const QuantisedError low = is_true           ? q.least
                               : q.is_in_section ? q.bound
                                                 : q.finest,
                         high = !is_true          ? batch_.bound[i]
                                : q.is_in_section ? kAnyError
                                                  : q.bound;
    if (low != high) continue;
    source_.onSettled(c.slot, low);
    frontier.settle(c.page, lowOf(c.slot));
  }
}

void TerrainTester::tellAddable(int level, std::span<const AdaptCandidate> candidates) {
  scratch_.slots.clear();
  for (const AdaptCandidate& c : candidates)
    if (c.is_new && !c.is_known) scratch_.slots.push_back(c.slot);
  if (!scratch_.slots.empty()) source_.onAddable(level, scratch_.slots);
}

void TerrainTester::endStep(Frontier& frontier, uint32_t steps) {
  constexpr uint32_t kPeriod = 8;
  frontier.endStep([this](const FrontierPage& page) { memory_.pages.keep(page.first(), page.knowledge); });
  const Frontier::Nodes& nodes = frontier.nodes();
  if (!memory_.hides || steps % kPeriod != 0) return;
  memory_.blocks.retainTiles([&](const BlockId& lowest) { return hasNodesNear(domain_.grid, nodes, lowest); });
}

}  // namespace foreland::proto
