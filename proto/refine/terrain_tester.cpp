#include "proto/refine/terrain_tester.h"

namespace foreland::proto {

namespace {

constexpr QuantisedError kMinError{1}, kAnyError{255};

}  // namespace

void TerrainTester::test() {
  decides_ = false;
  source_.load(batch_);
  if (isSwept()) return batch_.test(domain_, metric_);
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
    else if (c.is_in_section && batch_.bound[i] == kMinError)
      batch_.bound[i] = std::max(kMinError, nodes.page(c.page).knowledge.finest);
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
  decides_ = true;
  if (isSwept()) return true;
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
// error is not, all that is known is that it was asked about. With few branches, for nothing foretells the decisions.
bool TerrainTester::resolve(size_t i, AdaptCandidate& c, QuantisedError finest) {
  const bool is_unsettled = !c.is_settled, was_in_section = c.is_in_section;
  const uint16_t least = batch_.least[i];
  if (c.is_new & c.is_known & !was_in_section & is_unsettled & (finest.value >= least)) {
    batch_.bound[i] = finest;
    c.is_in_section = true;
    return true;
  }
  const bool passes = batch_.bound[i].value >= least;
  const bool is_decided = !is_unsettled | (least == TerrainBatch::kNonePasses) | (passes == was_in_section);
  const bool is_forgotten = is_decided & was_in_section & !passes & is_unsettled;
  batch_.bound[i] = is_forgotten ? kAnyError : batch_.bound[i];
  c.is_in_section = is_decided ? passes : was_in_section;
  return is_decided;
}

ClientKnowledge TerrainTester::clientKnowledgeOf(size_t i, int level, const AdaptCandidate& c, QuantisedError least,
                                                 const Frontier::Nodes& nodes) const {
  if (c.is_known) return ClientKnowledge::kKnown;
  bool are_known = true;
  for (NodeId parent : domain_.grid.parents(node(i), level)) {
    const Slot above = domain_.grid.slot(parent, level - 1);
    are_known = are_known & nodes.pageAt(above).knowledge.known.has(lowOf(above));
  }
  if (!are_known) return ClientKnowledge::kNew;
  return nodes.page(c.page).knowledge.finest > least ? ClientKnowledge::kSeen : ClientKnowledge::kRejected;
}

void TerrainTester::collectPredicates(int level, std::span<AdaptCandidate> candidates, const Frontier::Nodes& nodes) {
  DecisionScratch& s = scratch_;
  s.asked.resize(candidates.size());
  size_t asked = 0;
  for (size_t i = 0; i < candidates.size(); ++i) {
    AdaptCandidate& c = candidates[i];
    is_hidden_[i] = memory_.hides && memory_.blocks.isKnownHidden(node(i)) ? 1 : 0;
    s.asked[asked] = static_cast<uint32_t>(i);
    asked += is_hidden_[i] != 0 || resolve(i, c, nodes.page(c.page).knowledge.finest) ? 0 : 1;
  }
  s.asked.resize(asked);
  s.predicates.resize(asked);
  for (size_t k = 0; k < asked; ++k) s.predicates[k] = predicateOf(s.asked[k], level, candidates[s.asked[k]], nodes);
}

Predicate TerrainTester::predicateOf(size_t i, int level, const AdaptCandidate& c, const Frontier::Nodes& nodes) const {
  const QuantisedError least{static_cast<uint8_t>(batch_.least[i])};
  return {.slot = c.slot,
          .bound = batch_.bound[i],
          .least = least,
          .is_in_section = c.is_in_section,
          .is_new = c.is_new,
          .is_known = c.is_known,
          .client_knowledge =
              c.is_new && !c.is_in_section ? clientKnowledgeOf(i, level, c, least, nodes) : ClientKnowledge::kNew,
          .finest = nodes.page(c.page).knowledge.finest};
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
    batch_.bound[s.asked[k]] = {static_cast<uint8_t>(least.value - (c.is_in_section ? 0 : 1))};
    frontier.noteDecision(c.page, least);
  }
  return true;
}

bool TerrainTester::tellAdded(int level, std::span<const AdaptCandidate> candidates) {
  DecisionScratch& s = scratch_;
  s.added.resize(s.asked.size());
  size_t added = 0;
  for (size_t k = 0; k < s.asked.size(); ++k) {
    s.added[added] = s.predicates[k];
    const bool is_known = s.predicates[k].is_known, is_in_section = candidates[s.asked[k]].is_in_section;
    added += (!is_known & is_in_section) ? 1 : 0;
  }
  s.added.resize(added);
  return s.added.empty() || source_.onAdded(level, s.added);
}

// Notes the errors that a decision and what was known before leave no doubt about.
void TerrainTester::settle(std::span<const AdaptCandidate> candidates, Frontier& frontier) {
  const DecisionScratch& s = scratch_;
  for (size_t k = 0; k < s.asked.size(); ++k) {
    const Predicate& q = s.predicates[k];
    const uint32_t i = s.asked[k];
    const AdaptCandidate& c = candidates[i];
    const bool is_true = s.decisions[k] != 0;
    const QuantisedError below = q.is_in_section ? q.bound : q.finest, above = q.is_in_section ? kAnyError : q.bound;
    const QuantisedError low = is_true ? q.least : below, high = is_true ? above : batch_.bound[i];
    const bool is_open = low != high, is_hidden = is_hidden_[i] != 0;
    if (is_open | is_hidden | (!q.is_known & !c.is_in_section)) continue;
    source_.onSettled(c.slot, low);
    frontier.settle(c.page, lowOf(c.slot));
  }
}

void TerrainTester::tellAddable(int level, std::span<const AdaptCandidate> candidates) {
  scratch_.slots.resize(candidates.size());
  size_t told = 0;
  for (const AdaptCandidate& c : candidates) {
    scratch_.slots[told] = c.slot;
    told += (c.is_new & !c.is_known) ? 1 : 0;
  }
  scratch_.slots.resize(told);
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
