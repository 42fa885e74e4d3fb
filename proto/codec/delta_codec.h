// Cut deltas as bytes. Both ends run the same adaptation (refine/adapter.h) for the keyframe's view, so whatever
// follows from the view and from the bounds that both ends know is not sent. Sent are, in the order in which the
// adapter pulls them from its source,
//   blocks     which blocks of the terrain are hidden (block_coder.h), on connections whose welcome says so
//   decisions  of predicates: whether a node's error is at least the least that the view shows
//   heights    of the nodes that are added to the section, exact
//   radii      one for each page that was empty so far
// and then the changes of each object of the scene (surface_codec.h). Each is coded by an adaptive range coder, with
// what both ends know around the node as context. docs/decisions/0006 has the measurements.
//
// Encoder and decoder are sources of an adapter: the adapter's step calls them. The model keeps what it has learnt from
// delta to delta; both ends begin with a new one wherever a delta starts from a resumed section or from nothing. Any
// bytes end in a closed section or in an Error, in time and memory linear in the bytes and the section held. One owner
// of a model; otherwise pure; any thread. Portable to WebAssembly.
#pragma once

#include <algorithm>
#include <array>

#include "base/bytes.h"
#include "base/result.h"
#include "proto/codec/block_coder.h"
#include "proto/codec/prediction_context.h"
#include "proto/codec/symbols.h"
#include "proto/refine/adapter.h"
#include "proto/refine/terrain_source.h"
#include "proto/section/node_tables.h"

namespace foreland::proto {

// Nodes in a section that a client accepts.
inline constexpr size_t kMaxSectionNodes = 1u << 24;

// What both ends have learnt.
struct DeltaModel {
  static constexpr size_t kSizes = 16, kScales = 28, kRatios = 4;

  std::array<AdaptiveBit, 4 * kSizes * 8 * 4> newly_addable;  // nodes new to the frontier
  std::array<AdaptiveBit, kSizes * 8 * 8> addable;            // others
  std::array<AdaptiveBit, 2 * 4 * 8> leaf;                    // leaves
  std::array<NumberModel, kScales * kRatios * 2> height;
  std::array<std::array<AdaptiveBit, 8>, 2> radius;
  EscapeModel escape;
  BlockModel blocks;
  bool signals_blocks = false;  // of the connection (Welcome::occlusion): deltas say which blocks are hidden

  // As at the start of a connection.
  static DeltaModel forConnection(bool signals_blocks) {
    DeltaModel model;
    model.signals_blocks = signals_blocks;
    return model;
  }
};

// The contexts of nodes whose predicates are true, in order, until they are added: of one group.
class CachedContexts {
 public:
  void clear() { count_ = taken_ = 0; }
  // Without a branch, for nothing foretells which are kept.
  void keepIf(bool is_kept, Slot slot, const PredictionContext& context) {
    slots_[count_] = slot;
    contexts_[count_] = context;
    count_ += is_kept ? 1 : 0;
  }
  // Nodes are taken in the order in which they were kept; some may be left out.
  const PredictionContext& take(Slot slot) {
    while (slots_[taken_] != slot) ++taken_;
    return contexts_[taken_];
  }

 private:
  // One more than are kept.
  std::array<Slot, TerrainBatch::kSize + 1> slots_;
  std::array<PredictionContext, TerrainBatch::kSize + 1> contexts_;
  size_t count_ = 0, taken_ = 0;
};

// Where a coder's bits went, and for how many.
struct DeltaBits {
  double decisions = 0, heights = 0, radii = 0, blocks = 0;
  uint64_t asked = 0, added = 0, blocks_asked = 0, blocks_changed = 0;
};

// The server's end: appends a delta to `out` as an adapter steps.
class DeltaEncoder final : public TerrainSource {
 public:
  // Nodes of blocks that `visibility` calls hidden are left out; of none if it is null, which it must be unless the
  // model tells blocks.
  DeltaEncoder(const TerrainDomain& domain, const DenseNodes& nodes, DeltaModel& model, Bytes& out,
               BlockVisibility* visibility = nullptr)
      : domain_(domain), nodes_(nodes), model_(model), coder_(out), visibility_(visibility) {}
  QuantisedRadius radius(Slot first) override;
  void load(TerrainBatch& batch) override;
  bool decide(int level, std::span<const Predicate> predicates, std::span<uint8_t> decisions) override;
  bool onAdded(int level, std::span<const Predicate> added) override;
  bool reviseBlocks(const HiddenBlocks& blocks, bool& hides, std::vector<BlockId>& changed) override;
  bool isHidden(const HiddenBlocks& blocks, const BlockId& block) override;
  // First in a delta from the empty section: what the client remembers then.
  void codeRestart(Remembered remembered) { coder_.codeEvenly(remembered == Remembered::kPages ? 1 : 0, 1); }
  // For what else the delta has: the nodes of objects.
  RangeEncoder& coder() { return coder_; }
  // Writes what is left. Nothing may follow the delta's bytes.
  void finish() { coder_.finish(); }
  const DeltaBits& bits() const { return bits_; }

 private:
  const TerrainDomain& domain_;
  const DenseNodes& nodes_;
  DeltaModel& model_;
  RangeEncoder coder_;
  BlockVisibility* visibility_;
  CachedContexts cached_contexts_;
  DeltaBits bits_;
};

// The client's end: reads a delta into `nodes` as an adapter steps. If the step fails, or finish() does, the bytes were
// no delta for this section.
class DeltaDecoder final : public TerrainSource {
 public:
  DeltaDecoder(const TerrainDomain& domain, SparseNodes& nodes, DeltaModel& model, ByteSpan bytes)
      : domain_(domain), nodes_(nodes), model_(model), coder_(bytes) {}
  QuantisedRadius radius(Slot first) override;
  void onAddable(int level, std::span<const Slot> slots) override;
  void load(TerrainBatch& batch) override;
  bool decide(int level, std::span<const Predicate> predicates, std::span<uint8_t> decisions) override;
  bool onAdded(int level, std::span<const Predicate> added) override;
  void onSettled(Slot slot, QuantisedError error) override;
  bool reviseBlocks(const HiddenBlocks& blocks, bool& hides, std::vector<BlockId>& changed) override;
  bool isHidden(const HiddenBlocks& blocks, const BlockId& block) override;
  Remembered codeRestart() { return coder_.codeEvenly(0, 1) != 0 ? Remembered::kPages : Remembered::kNothing; }
  RangeDecoder& coder() { return coder_; }
  Status finish() const;

 private:
  const TerrainDomain& domain_;
  SparseNodes& nodes_;
  DeltaModel& model_;
  RangeDecoder coder_;
  CachedContexts cached_contexts_;
  bool absurd_ = false;
};

}  // namespace foreland::proto
