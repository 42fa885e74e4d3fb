#include "proto/refine/terrain_tester.h"

#include "proto/refine/page_neighbours.h"

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
void TerrainTester::setBounds(const CandidateColumns& c, const Frontier::Nodes& nodes) {
  for (size_t i = 0; i < c.count; ++i)
    if (c.isSettled(i))
      batch_.bound[i] = batch_.recorded[i];
    else if (c.in_section[i] != 0 && batch_.bound[i] == kMinError)
      batch_.bound[i] = std::max(kMinError, nodes.page(c.page[i]).knowledge.finest);
}

bool TerrainTester::decide(int level, CandidateColumns& candidates, Frontier& frontier) {
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
  for (size_t i = 0; memory_.hides && i < candidates.count; ++i)
    if (is_hidden_[i] != 0) batch_.slack[i] = EntryPool::kEndless;
  return true;
}

// Nothing is known of the error of a node that is held back, unless it was told.
void TerrainTester::leaveOutHidden(CandidateColumns& c) {
  const auto ask = [&](const BlockId& block) { return source_.isHidden(memory_.blocks, block); };
  for (size_t i = 0; i < c.count; ++i) {
    if (is_hidden_[i] == 0 && (c.in_section[i] == 0 || !memory_.blocks.isHidden(node(i), ask))) continue;
    is_hidden_[i] = 1;
    c.in_section[i] = 0;
    if (!c.isSettled(i)) batch_.bound[i] = kAnyError;
  }
}

// Whether what is known of the error decides. The view may say that no error passes; of a node that is known but whose
// error is not, all that is known is that it was asked about. With few branches, for nothing foretells the decisions.
bool TerrainTester::resolve(size_t i, CandidateColumns& c, QuantisedError finest) {
  const bool is_unsettled = !c.isSettled(i), was_in_section = c.in_section[i] != 0, is_new = c.isNew(i),
             is_known = c.isKnown(i);
  const uint16_t least = batch_.least[i];
  if (is_new & is_known & !was_in_section & is_unsettled & (finest.value >= least)) {
    batch_.bound[i] = finest;
    c.in_section[i] = 1;
    return true;
  }
  const bool passes = batch_.bound[i].value >= least;
  const bool is_decided = !is_unsettled | (least == TerrainBatch::kNonePasses) | (passes == was_in_section);
  const bool is_forgotten = is_decided & was_in_section & !passes & is_unsettled;
  batch_.bound[i] = is_forgotten ? kAnyError : batch_.bound[i];
  c.in_section[i] = is_decided ? passes : was_in_section;
  return is_decided;
}

// For all nodes of a page at once, and once for each page.
class TerrainTester::KnownParents {
 public:
  KnownParents(const GridTopology& grid, const Frontier::Nodes& nodes, int level)
      : neighbours_(grid, nodes, PageNeighbours::Of::kKnown), nodes_(nodes), level_(level) {}
  bool areKnown(uint32_t page, uint8_t low) {
    if (page != page_) {
      page_ = page;
      known_ = level_ == 1 ? SlotBits::below(kPageSlots)
                           : neighbours_.withParents(level_, neighbours_.placeOf(level_, nodes_.page(page).first()));
    }
    return known_.has(low);
  }

 private:
  const PageNeighbours neighbours_;
  const Frontier::Nodes& nodes_;
  const int level_;
  uint32_t page_ = Frontier::Nodes::kNone;
  SlotBits known_;
};

void TerrainTester::collectPredicates(int level, CandidateColumns& c, const Frontier::Nodes& nodes) {
  DecisionScratch& s = scratch_;
  s.asked.resize(c.count);
  size_t asked = 0;
  for (size_t i = 0; i < c.count; ++i) {
    is_hidden_[i] = memory_.hides && memory_.blocks.isKnownHidden(node(i)) ? 1 : 0;
    s.asked[asked] = static_cast<uint32_t>(i);
    asked += is_hidden_[i] != 0 || resolve(i, c, nodes.page(c.page[i]).knowledge.finest) ? 0 : 1;
  }
  s.asked.resize(asked);
  s.predicates.resize(asked);
  KnownParents parents(domain_.grid, nodes, level);
  for (size_t k = 0; k < asked; ++k) {
    const uint32_t i = s.asked[k], page = c.page[i];
    const QuantisedError least{static_cast<uint8_t>(batch_.least[i])}, finest = nodes.page(page).knowledge.finest;
    auto knowledge = ClientKnowledge::kNew;
    if (c.isNew(i) && c.in_section[i] == 0)
      knowledge = c.isKnown(i)                                     ? ClientKnowledge::kKnown
                  : !parents.areKnown(page, lowOf(batch_.slot[i])) ? ClientKnowledge::kNew
                  : finest > least                                 ? ClientKnowledge::kSeen
                                                                   : ClientKnowledge::kRejected;
    s.predicates[k] = {.slot = batch_.slot[i],
                       .bound = batch_.bound[i],
                       .least = least,
                       .is_in_section = c.in_section[i] != 0,
                       .is_new = c.isNew(i),
                       .is_known = c.isKnown(i),
                       .client_knowledge = knowledge,
                       .finest = finest};
  }
}

bool TerrainTester::askSource(int level, CandidateColumns& c, Frontier& frontier) {
  collectPredicates(level, c, frontier.nodes());
  DecisionScratch& s = scratch_;
  s.decisions.resize(s.predicates.size());
  if (!s.predicates.empty() && !source_.decide(level, s.predicates, s.decisions)) return false;
  for (size_t k = 0; k < s.asked.size(); ++k) {
    const uint32_t i = s.asked[k];
    const QuantisedError least = s.predicates[k].least;
    c.in_section[i] = s.decisions[k] != 0 ? 1 : 0;
    batch_.bound[i] = {static_cast<uint8_t>(least.value - (c.in_section[i] != 0 ? 0 : 1))};
    frontier.noteDecision(c.page[i], least);
  }
  return true;
}

bool TerrainTester::tellAdded(int level, const CandidateColumns& c) {
  DecisionScratch& s = scratch_;
  s.added.resize(s.asked.size());
  size_t added = 0;
  for (size_t k = 0; k < s.asked.size(); ++k) {
    s.added[added] = s.predicates[k];
    const bool is_known = s.predicates[k].is_known, is_in_section = c.in_section[s.asked[k]] != 0;
    added += (!is_known & is_in_section) ? 1 : 0;
  }
  s.added.resize(added);
  return s.added.empty() || source_.onAdded(level, s.added);
}

// Notes the errors that a decision and what was known before leave no doubt about.
void TerrainTester::settle(const CandidateColumns& c, Frontier& frontier) {
  const DecisionScratch& s = scratch_;
  for (size_t k = 0; k < s.asked.size(); ++k) {
    const Predicate& q = s.predicates[k];
    const uint32_t i = s.asked[k];
    const bool is_true = s.decisions[k] != 0;
    const QuantisedError below = q.is_in_section ? q.bound : q.finest, above = q.is_in_section ? kAnyError : q.bound;
    const QuantisedError low = is_true ? q.least : below, high = is_true ? above : batch_.bound[i];
    const bool is_open = low != high, is_hidden = is_hidden_[i] != 0;
    if (is_open | is_hidden | (!q.is_known & (c.in_section[i] == 0))) continue;
    source_.onSettled(q.slot, low);
    frontier.settle(c.page[i], lowOf(q.slot));
  }
}

void TerrainTester::tellAddable(int level, std::span<const CandidatePage> candidates, const Frontier::Nodes& nodes) {
  scratch_.slots.clear();
  for (const CandidatePage& c : candidates) {
    const FrontierPage& page = nodes.page(c.number);
    (c.entering - page.knowledge.known).forEach([&](uint8_t low) { scratch_.slots.push_back(page.first() | low); });
  }
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
