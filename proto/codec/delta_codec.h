// The delta codec writes cut deltas as bytes and reads them. Both ends run the same adaptation (refine/adapter.h) for
// the keyframe's view, so nothing is sent that follows from the view and from the bounds that both ends know. A delta
// holds five kinds of numbers, each where the adapter pulls it from its source:
//   blocks     say which blocks of the terrain are hidden (block_coder.h), on connections whose welcome says so
//   decisions  are answers to predicates: is a node's error at least the least that the view shows? One bit says of
//              all of a page's nodes that have probably been refused before that they are refused again
//   heights    are those of the nodes that are added to the section, exact
//   pages      say of each page of a sparse level that was empty so far whether it is there
//   radii      are one for each page that was empty so far, and is there
// The changes of each object of the scene follow (surface_codec.h). An adaptive range coder codes every number, and
// takes what both ends know around the node as context. docs/decisions/0006 has the measurements.
//
// Encoder and decoder are sources of an adapter, whose step calls them. The model keeps what it has learnt from delta
// to delta; both ends begin with a new model wherever a delta starts from a resumed section or from nothing. Any bytes
// end in a closed section or in an Error, in time and memory linear in the bytes and the section held. A model has one
// owner; beside it the codec is pure. Any thread may use it, and it is portable to WebAssembly.
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

// A client accepts sections of at most this many nodes: as many as 4096 x 4096 samples have. The limit is the
// protocol's (docs/PROTOCOL.md, section 13), and bounds what a hostile server makes a client allocate.
inline constexpr size_t kMaxSectionNodes = 1u << 24;

// DeltaModel is what both ends have learnt of the stream. Most contexts are bins of the error that is expected of a
// node and of the least error that the view shows. kSizes bins of half an octave hold the ratio of the two, from 2^-4
// to 2^4; kScales bins of half an octave hold the larger one in quanta, from 2^-2 to 2^12; kRatios bins hold the ratio
// coarsely. What lies outside falls into the first or the last bin.
struct DeltaModel {
  static constexpr size_t kSizes = 16, kScales = 28, kRatios = 4, kCounts = 8;

  std::array<AdaptiveBit, 4 * kSizes * 8 * 4> newly_addable;  // Nodes that are new to the frontier use these.
  std::array<AdaptiveBit, kSizes * 8 * 8> addable;            // Other nodes that can be added use these.
  std::array<AdaptiveBit, 2 * 4 * 8> leaf;
  std::array<NumberModel, kScales * kRatios * 2> height;
  std::array<AdaptiveBit, 8> radius;
  std::array<AdaptiveBit, kCounts> refused;  // by the octave of how many nodes of a page this is about
  std::array<AdaptiveBit, 8> has_page;       // by the last three answers of the delta
  EscapeModel escape;
  BlockModel blocks;
  bool signals_blocks = false;  // Deltas of the connection say which blocks are hidden (Welcome::occlusion).

  // Every connection starts with this model.
  static DeltaModel forConnection(bool signals_blocks) {
    DeltaModel model;
    model.signals_blocks = signals_blocks;
    return model;
  }
};

// CachedContexts keeps, for one batch, the contexts of nodes whose predicates are true until the nodes are added.
class CachedContexts {
 public:
  void clear() { count_ = taken_ = 0; }
  // keepIf() has no branch, since nothing predicts which contexts are kept.
  void keepIf(bool is_kept, Slot slot, const PredictionContext& context) {
    slots_[count_] = slot;
    contexts_[count_] = context;
    count_ += is_kept ? 1 : 0;
  }
  // Contexts are taken in the order in which they were kept; some may be left out.
  const PredictionContext& take(Slot slot) {
    while (slots_[taken_] != slot) ++taken_;
    return contexts_[taken_];
  }

 private:
  // A context that is not kept is written behind the last one that is, so there is one more than a batch has nodes.
  std::array<Slot, TerrainBatch::kSize + 1> slots_;
  std::array<PredictionContext, TerrainBatch::kSize + 1> contexts_;
  size_t count_ = 0, taken_ = 0;
};

// DeltaBits says how many bits each kind of number took, and how many nodes and blocks these were about.
struct DeltaBits {
  double decisions = 0, heights = 0, radii = 0, blocks = 0, pages = 0;
  uint64_t asked = 0, added = 0, blocks_asked = 0, blocks_changed = 0, pages_asked = 0;
};

// The server's end appends a delta to `out` as an adapter steps.
class DeltaEncoder final : public TerrainSource {
 public:
  // Nodes of blocks that `visibility` calls hidden are left out. `visibility` must be null unless the model signals
  // blocks; no node is left out then.
  DeltaEncoder(const TerrainDomain& domain, const DenseNodes& nodes, DeltaModel& model, Bytes& out,
               BlockVisibility* visibility = nullptr)
      : domain_(domain), nodes_(nodes), model_(model), coder_(out), visibility_(visibility) {}
  bool hasPage(Slot first) override;
  QuantisedRadius radius(Slot first) override;
  void load(TerrainBatch& batch) override;
  bool decide(int level, std::span<const Predicate> predicates, std::span<uint8_t> decisions) override;
  bool onAdded(int level, std::span<const Predicate> added) override;
  bool reviseBlocks(const HiddenBlocks& blocks, bool& hides, std::vector<BlockId>& changed) override;
  bool isHidden(const HiddenBlocks& blocks, const BlockId& block) override;
  // Codes what the client goes on remembering. Must be called first in a delta from the empty section, and in no other.
  void codeRestart(Remembered remembered) { coder_.codeEvenly(remembered == Remembered::kPages ? 1 : 0, 1); }
  // The nodes of objects, which the delta also holds, are coded by this coder.
  RangeEncoder& coder() { return coder_; }
  // Writes the coder's last bytes. Nothing may follow the delta's bytes in `out`.
  void finish() { coder_.finish(); }
  const DeltaBits& bits() const { return bits_; }

 private:
  const TerrainDomain& domain_;
  const DenseNodes& nodes_;
  DeltaModel& model_;
  RangeEncoder coder_;
  BlockVisibility* visibility_;
  CachedContexts cached_contexts_;
  size_t pages_before_ = 0;  // the last three answers of hasPage()
  DeltaBits bits_;
};

// The client's end reads a delta into `nodes` as an adapter steps. If the step or finish() fails, the bytes were no
// delta for this section.
class DeltaDecoder final : public TerrainSource {
 public:
  DeltaDecoder(const TerrainDomain& domain, SparseNodes& nodes, DeltaModel& model, ByteSpan bytes)
      : domain_(domain), nodes_(nodes), model_(model), coder_(bytes) {}
  bool hasPage(Slot first) override;
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
  size_t pages_before_ = 0;  // as the encoder has it
  bool absurd_ = false;
};

}  // namespace foreland::proto
