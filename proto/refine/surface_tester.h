// How an adapter (adapter.h) tests nodes of a surface: their records are known, so every test is decided at once. Nodes
// are tested in batches, in columns. A step's own; too large to be copied.
#pragma once

#include <array>
#include <cstdint>
#include <span>

#include "proto/refine/adapt_scratch.h"
#include "proto/refine/frontier.h"
#include "proto/refine/surface/surface_domain.h"

namespace foreland::proto {

class SurfaceTester {
 public:
  using Domain = SurfaceDomain;
  using Source = const std::span<const SurfaceRecord>;  // by slot
  static constexpr size_t kSize = 256;

  // Nothing is remembered beside the frontier.
  struct Memory {
    explicit Memory(const Domain&) {}
    size_t bytes() const { return 0; }
    std::optional<QuantisedRadius> radius(Slot) const { return std::nullopt; }
    SlotBits known(Slot) const { return {}; }
    bool knowsAnyOf64(Slot) const { return false; }
    void keep(Slot, const PageKnowledge&) {}
    void restart(Remembered) {}
    std::vector<KnownPage> knownPages() const { return {}; }
  };

  SurfaceTester(const Domain& domain, const View& view, const MotionBound&, Source& records, Memory&, DecisionScratch&)
      : metric_(domain.metric(view)), quantum_m_(domain.quantum_m), records_(records.data()) {}

  // Spheres are in the records, so nothing is said of pages.
  static PageKnowledge knowledgeOf(Source&, Memory&, Slot) { return {}; }

  template <class Undecide>
  bool reviseBlocks(const Frontier::Nodes&, const Undecide&) {
    return true;
  }
  void endStep(Frontier& frontier, uint32_t) {
    frontier.endStep([](const FrontierPage&) {});
  }

  static FrontierEntry unknownLeaf(const Domain&, uint8_t low) { return FrontierEntry::newLeaf(low); }
  static EntryKind entryKind(const Domain&) { return EntryKind::kSlack; }

  size_t count() const { return count_; }
  bool full() const { return count_ == kSize; }
  void clear() { count_ = 0; }
  float radius(int, const FrontierPage&) const { return 0; }
  void push(NodeId, Slot slot, int, QuantisedError, float) { slot_[count_++] = slot; }

  // As TerrainTester has them.
  void test();
  bool decide(int, CandidateColumns& candidates, Frontier&) {
    test();
    for (size_t i = 0; i < candidates.count; ++i) candidates.in_section[i] = passes(i) ? 1 : 0;
    return true;
  }
  Slot slot(size_t i) const { return slot_[i]; }
  bool passes(size_t i) const { return passes_[i] != 0; }
  FrontierEntry entry(size_t i, bool) const {
    return FrontierEntry::of(lowOf(slot_[i]), {}, constraint_[i], slack_[i]);
  }
  void tellAddable(int, std::span<const CandidatePage>, const Frontier::Nodes&) {}

 private:
  const SurfaceMetric metric_;
  const double quantum_m_;
  const SurfaceRecord* records_;
  size_t count_ = 0;
  std::array<Slot, kSize> slot_;
  std::array<SurfaceBounds, kSize> bounds_;
  std::array<uint8_t, kSize> passes_;
  std::array<float, kSize> slack_;
  std::array<MotionConstraint, kSize> constraint_;
};

}  // namespace foreland::proto
