#include "proto/codec/delta_codec.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <type_traits>

#include "base/bit_instructions.h"
#include "base/vectors.h"
#include "proto/codec/symbols.h"

namespace foreland::proto {

namespace {

// Halves of octaves, rounded down: floor(2 log2 x) up to the mantissa's linearity. x > 0.
int halfOctaves(double x) { return static_cast<int>(std::bit_cast<uint64_t>(x) >> 51) - 2 * 1023; }

bool arePageMates(Slot a, Slot b) { return a / kPageSlots == b / kPageSlots; }

size_t binOf(int x, std::initializer_list<int> edges) {
  size_t bin = 0;
  for (int edge : edges) bin += x >= edge ? 1 : 0;
  return bin;
}

constexpr std::array<uint16_t, TerrainBatch::kSize> kAll = [] {
  std::array<uint16_t, TerrainBatch::kSize> all{};
  for (size_t i = 0; i < all.size(); ++i) all[i] = static_cast<uint16_t>(i);
  return all;
}();

// One level's nodes, one after the other, with the contexts of each.
template <class Coder, class Nodes>
class LevelCoder {
  // A client's do, but for those that were made otherwise, of a section in tests.
  static constexpr bool kRecordsHaveEnds = std::is_same_v<Nodes, SparseNodes>;

 public:
  LevelCoder(const TerrainDomain& domain, const Nodes& nodes, DeltaModel& model, Coder& coder, CachedContexts& asked,
             int level)
      : grid_(domain.grid),
        names_(grid_, level),
        apexes_(grid_, level),
        level_(level),
        nodes_(nodes),
        cached_contexts_(asked),
        model_(model),
        coder_(coder),
        symbols_(coder, model.escape),
        scale_(static_cast<size_t>(std::min((grid_.maxLevel() - level) / 2, 7))),
        quanta_per_m_(1 / domain.frame.transform().frame().height_quantum_m) {}

  // An encoder passes the decisions, a decoder gets them. The contexts of some nodes are looked up before the first of
  // them is coded, so that their look-ups wait for memory together.
  FORELAND_WITH_BIT_INSTRUCTIONS void codeDecisions(std::span<const Predicate> predicates,
                                                    std::span<uint8_t> decisions) {
    cached_contexts_.clear();
    const std::span<const uint16_t> left = codeRefusals(predicates, decisions);
    constexpr size_t kAhead = 64;
    std::array<Records, kAhead> records;
    std::array<Context, kAhead> contexts;
    for (size_t begin = 0; begin < left.size(); begin += kAhead) {
      const auto some = left.subspan(begin, std::min(kAhead, left.size() - begin));
      for (size_t i = 0; i < some.size(); ++i) find(predicates[some[i]], records[i]);
      for (size_t i = 0; i < some.size(); ++i) contexts[i] = contextOf(predicates[some[i]], records[i]);
      for (size_t i = 0; i < some.size(); ++i)
        decisions[some[i]] = codeDecision(contexts[i], decisions[some[i]] != 0) ? 1 : 0;
      for (size_t i = 0; i < some.size(); ++i) {
        const Predicate& q = predicates[some[i]];
        cached_contexts_.keepIf(decisions[some[i]] & !q.is_in_section, q.slot, contexts[i].context);
      }
    }
  }

  // The height of an added node; nodes come in order. An encoder passes it, a decoder gets it.
  int32_t codeHeight(const Predicate& added, int32_t height) {
    return codeHeight(cached_contexts_.take(added.slot), added.least, height);
  }

 private:
  static bool isRejected(const Predicate& q) { return q.client_knowledge == ClientKnowledge::kRejected; }
  // Codes for each page whether all of its nodes that have probably been refused before are refused again. Mostly they
  // are, and then nothing else is coded about them. The result are the predicates that are left, by their index.
  std::span<const uint16_t> codeRefusals(std::span<const Predicate> predicates, std::span<uint8_t> decisions) {
    if (std::ranges::none_of(predicates, isRejected)) return std::span(kAll).first(predicates.size());
    size_t left = 0;
    for (size_t begin = 0, end = 0; begin < predicates.size(); begin = end) {
      uint32_t count = 0, any = 0;
      for (; end < predicates.size() && arePageMates(predicates[begin].slot, predicates[end].slot); ++end) {
        const uint32_t is_rejected = isRejected(predicates[end]) ? 1 : 0;
        count += is_rejected;
        any |= is_rejected & decisions[end];
      }
      const size_t octave = std::clamp<size_t>(static_cast<size_t>(std::bit_width(count)), 1, DeltaModel::kCounts) - 1;
      const bool are_refused = count > 0 && coder_.code(model_.refused[octave], any == 0);
      for (size_t i = begin; i < end; ++i) {
        const bool is_refused = are_refused && isRejected(predicates[i]);
        decisions[i] = is_refused ? 0 : decisions[i];
        left_[left] = static_cast<uint16_t>(i);
        left += is_refused ? 0 : 1;
      }
    }
    return std::span(left_).first(left);
  }

  int32_t codeHeight(const PredictionContext& context, QuantisedError passed, int32_t height) {
    const double least = quantaOf(passed), expected = context.expected();
    const size_t scale = static_cast<size_t>(
        std::clamp(halfOctaves(std::max(least, expected)) + 4, 0, static_cast<int>(DeltaModel::kScales) - 1));
    const size_t ratio = binOf(halfOctaves(expected / least), {-2, 0, 2});
    const bool is_curved = 2.0 * std::abs(context.curve()) >= least;
    auto& number = model_.height[(scale * DeltaModel::kRatios + ratio) * 2 + (is_curved ? 1 : 0)];
    const int32_t guess = context.guess();
    const size_t curvature_sign = !is_curved ? 0 : context.curve() < 0 ? 1 : 2;
    return inRange(int64_t{guess} + symbols_.number(number, curvature_sign, height - guess));
  }

  // The context of a decision: a bit, or four bits, of which the last two decisions choose one.
  struct Context {
    AdaptiveBit* bits;
    bool has_before;
    PredictionContext context;  // unless the node is in the section
  };
  // What the context depends on: the record of a node that is in the section, else the records around the node, or
  // those of its apexes and its own, if that has the ends.
  struct Records {
    const NodeRecord* own;
    PredictionContext::Neighbours context;
  };
  void find(const Predicate& q, Records& found) {
    const NodeRecord* const own = kRecordsHaveEnds || q.is_in_section ? &nodes_.at(q.slot) : nullptr;
    found.own = own;
    if (q.is_in_section) {
      if (!kRecordsHaveEnds) __builtin_prefetch(own);  // load() has just read a client's
      return;
    }
    const NodeId n = names_.at(q.slot);
    if (!kRecordsHaveEnds || !own->hasEnds()) {
      found.own = nullptr;
      found.context.ends = PredictionContext::findEnds(grid_, nodes_, n, level_);
    }
    found.context.apexes = findApexes(n);
  }
  PredictionContext::Vertices findApexes(NodeId n) const {
    return level_ == 1 ? PredictionContext::findApexes(grid_, nodes_, n, level_)
                       : PredictionContext::findApexes(apexes_, nodes_, n);
  }
  Context contextOf(const Predicate& q, const Records& records) {
    if (q.is_in_section) {
      const double own = std::abs(records.own->displacement()) + 0.25;
      const size_t size = static_cast<size_t>(std::clamp(halfOctaves(own / quantaOf(q.least)) + 5, 0, 7));
      const size_t width = std::min<size_t>(static_cast<size_t>(q.least.value - q.bound.value - 1), 3);
      return {&model_.leaf[(static_cast<size_t>(q.is_new) * 4 + width) * 8 + size], false, {}};
    }
    const PredictionContext context = records.own ? PredictionContext::of(records.own->ends(), records.context.apexes)
                                                  : PredictionContext::of(records.context);
    const size_t size = sizeOf(context, q.least);
    if (q.is_new) {
      const auto client_knowledge = static_cast<size_t>(q.client_knowledge);
      const size_t finer = static_cast<size_t>(std::min(std::abs(q.finest.value - q.least.value), 7));
      const size_t third = q.client_knowledge == ClientKnowledge::kNew ? scale_ : finer;
      return {&model_.newly_addable[((client_knowledge * DeltaModel::kSizes + size) * 8 + third) * 4], true, context};
    }
    const size_t width = std::min<size_t>(static_cast<size_t>(q.bound.value - q.least.value), 7);
    return {&model_.addable[(size * 8 + width) * 8 + scale_], false, context};
  }
  size_t sizeOf(const PredictionContext& context, QuantisedError least) const {
    return static_cast<size_t>(std::clamp(halfOctaves(context.expected() / quantaOf(least)) + 8, 0, 15));
  }
  bool codeDecision(const Context& context, bool decide) {
    const bool got = coder_.code(context.bits[context.has_before ? before_ : 0], decide);
    if (context.has_before) before_ = (2 * before_ + (got ? 1 : 0)) & 3;
    return got;
  }

  double quantaOf(QuantisedError c) const { return static_cast<double>(c.metres()) * quanta_per_m_; }
  // Only hostile bytes lead outside the range.
  static int32_t inRange(int64_t height) {
    return static_cast<int32_t>(std::clamp<int64_t>(height, -kMaxHeight - 1, kMaxHeight + 1));
  }

  const GridTopology& grid_;
  LevelNodes names_;
  GridTopology::ApexSlots apexes_;
  int level_;
  const Nodes& nodes_;
  CachedContexts& cached_contexts_;
  DeltaModel& model_;
  Coder& coder_;
  Symbols<Coder> symbols_;
  size_t scale_;
  double quanta_per_m_;
  size_t before_ = 0;  // the last two decisions
  std::array<uint16_t, TerrainBatch::kSize> left_;
};

// An encoder passes whether the page is there, a decoder gets it. Where one page is there, its neighbours mostly are.
template <class Coder>
bool codeHasPage(Coder& coder, DeltaModel& model, size_t& before, bool has_page) {
  const bool got = coder.code(model.has_page[before], has_page);
  before = (2 * before + (got ? 1 : 0)) & 7;
  return got;
}

}  // namespace

bool DeltaEncoder::hasPage(Slot first) {
  const double before = coder_.bits();
  const bool has_page = codeHasPage(coder_, model_, pages_before_, nodes_.hasPage(first));
  bits_.pages += coder_.bits() - before;
  ++bits_.pages_asked;
  return has_page;
}

QuantisedRadius DeltaEncoder::radius(Slot first) {
  const double before = coder_.bits();
  const QuantisedRadius radius = nodes_.at(first).radius();
  Symbols(coder_, model_.escape).treeOrByte<3>(model_.radius, radius.value);
  bits_.radii += coder_.bits() - before;
  return radius;
}

void DeltaEncoder::load(TerrainBatch& batch) {
  runLoop<Vectors::kAvx2>(
      widestVectors(), batch.count, [&](size_t begin, size_t end) __attribute__((always_inline)) {
        const DenseNodes nodes = nodes_;
        TerrainBatch& b = batch;
        for (size_t i = begin; i < end; ++i) b.setRecord(i, nodes.at(b.slot[i]));
      });
}

bool DeltaEncoder::decide(int level, std::span<const Predicate> predicates, std::span<uint8_t> decisions) {
  const double before = coder_.bits();
  LevelCoder<RangeEncoder, DenseNodes> level_coder(domain_, nodes_, model_, coder_, cached_contexts_, level);
  runWithBitInstructions([&]() FORELAND_WITH_BIT_INSTRUCTIONS {
    for (size_t i = 0; i < predicates.size(); ++i)
      decisions[i] = nodes_.at(predicates[i].slot).error() >= predicates[i].least ? 1 : 0;
    level_coder.codeDecisions(predicates, decisions);
  });
  bits_.decisions += coder_.bits() - before;
  bits_.asked += predicates.size();
  return true;
}

bool DeltaEncoder::onAdded(int level, std::span<const Predicate> added) {
  const double before = coder_.bits();
  LevelCoder<RangeEncoder, DenseNodes> level_coder(domain_, nodes_, model_, coder_, cached_contexts_, level);
  for (const Predicate& q : added) level_coder.codeHeight(q, nodes_.at(q.slot).height());
  bits_.heights += coder_.bits() - before;
  bits_.added += added.size();
  return true;
}

bool DeltaEncoder::reviseBlocks(const HiddenBlocks& blocks, bool& hides, std::vector<BlockId>& changed) {
  CHECK_TRUE(model_.signals_blocks || !visibility_);
  if (!model_.signals_blocks) return true;
  const double before = coder_.bits();
  BlockCoder(coder_, model_.blocks).codeChanges(blocks, visibility_, hides, changed);
  bits_.blocks += coder_.bits() - before;
  bits_.blocks_changed += changed.size();
  return true;
}

bool DeltaEncoder::isHidden(const HiddenBlocks& blocks, const BlockId& block) {
  const double before = coder_.bits();
  const bool is_hidden = BlockCoder(coder_, model_.blocks).codeHidden(blocks, block, visibility_->isHidden(block));
  bits_.blocks += coder_.bits() - before;
  ++bits_.blocks_asked;
  return is_hidden;
}

bool DeltaDecoder::hasPage(Slot) { return codeHasPage(coder_, model_, pages_before_, false); }

QuantisedRadius DeltaDecoder::radius(Slot) {
  const uint32_t value = Symbols(coder_, model_.escape).treeOrByte<3>(model_.radius, 0);
  return {static_cast<uint8_t>(std::min<uint32_t>(value, QuantisedRadius::kMax))};
}

// Until a node is added, only the middle of its edge is known.
void DeltaDecoder::onAddable(int level, std::span<const Slot> slots) {
  constexpr size_t kAhead = 64;  // nodes whose look-ups wait for memory together
  LevelNodes names(domain_.grid, level);
  std::array<std::array<VertexHeight, 2>, kAhead> ends;
  for (; !slots.empty(); slots = slots.subspan(std::min(kAhead, slots.size()))) {
    const size_t count = std::min(kAhead, slots.size());
    for (size_t i = 0; i < count; ++i) {
      const auto [a, b] = domain_.grid.endpoints(names.at(slots[i]), level);
      ends[i] = {nodes_.find(a), nodes_.find(b)};
      for (const VertexHeight& end : ends[i]) __builtin_prefetch(end.record);
    }
    std::array<NodeRecord, kAhead> records;  // before a new record moves the others
    for (size_t i = 0; i < count; ++i) records[i] = NodeRecord::ofEnds(ends[i][0].height(), ends[i][1].height());
    for (size_t i = 0; i < count; ++i) nodes_.make(slots[i]) = records[i];
  }
}

// The records are asked for before the first is read.
void DeltaDecoder::load(TerrainBatch& batch) {
  std::array<const NodeRecord*, TerrainBatch::kSize> records;
  for (size_t i = 0; i < batch.count; ++i) {
    records[i] = &nodes_.at(batch.slot[i]);
    __builtin_prefetch(records[i]);
  }
  for (size_t i = 0; i < batch.count; ++i) batch.setRecord(i, *records[i]);
}

bool DeltaDecoder::decide(int level, std::span<const Predicate> predicates, std::span<uint8_t> decisions) {
  LevelCoder<RangeDecoder, SparseNodes> level_coder(domain_, nodes_, model_, coder_, cached_contexts_, level);
  level_coder.codeDecisions(predicates, decisions);
  return !coder_.overrun();
}

bool DeltaDecoder::onAdded(int level, std::span<const Predicate> added) {
  LevelCoder<RangeDecoder, SparseNodes> level_coder(domain_, nodes_, model_, coder_, cached_contexts_, level);
  for (const Predicate& q : added) {
    const int32_t height = level_coder.codeHeight(q, 0);
    if (std::abs(height) > kMaxHeight) absurd_ = true;
    if (absurd_ || coder_.overrun()) return false;
    NodeRecord& record = nodes_.make(q.slot);
    record = record.withHeight(height);
  }
  return true;
}

void DeltaDecoder::onSettled(Slot slot, QuantisedError error) {
  NodeRecord& record = nodes_.make(slot);
  record = record.withError(error);
}

bool DeltaDecoder::reviseBlocks(const HiddenBlocks& blocks, bool& hides, std::vector<BlockId>& changed) {
  if (model_.signals_blocks) BlockCoder(coder_, model_.blocks).codeChanges(blocks, nullptr, hides, changed);
  return !coder_.overrun();
}

bool DeltaDecoder::isHidden(const HiddenBlocks& blocks, const BlockId& block) {
  return BlockCoder(coder_, model_.blocks).codeHidden(blocks, block, false);
}

Status DeltaDecoder::finish() const {
  if (absurd_) return Error{ErrorCode::kMalformed, "cut delta: an absurd height"};
  if (!coder_.atEnd()) return Error{ErrorCode::kMalformed, "cut delta: cut short, or bytes left over"};
  return {};
}

}  // namespace foreland::proto
