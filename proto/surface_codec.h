// The nodes of surfaces in a cut delta. Both ends run the same adaptation (refine/adapter.h), as they do for terrain
// (delta_codec.h), in the same stream of coded decisions. A surface's test takes more than a height, so the record of a
// node is sent when the node comes to the frontier; after that neither its coming nor its going costs anything.
//
// Records are coded by how they differ from what the node's parents lead to expect: a displacement a quarter of theirs,
// a normal that is their mean, a sphere of half and an error of a quarter of their size.
//
// The model keeps what it has learnt, for all objects of a session. Any bytes end in a closed section or in an Error.
// One owner; any thread; portable to WebAssembly.
#pragma once

#include <array>
#include <span>
#include <unordered_map>

#include "base/bytes.h"
#include "proto/refine/adapter.h"
#include "proto/refine/surface_batch.h"
#include "proto/symbols.h"

namespace foreland::proto {

using SurfaceAdapter = Adapter<SurfaceBatch>;

// Of a coordinate of what is sent, so that differences fit.
inline constexpr int32_t kMaxObjectSteps = 1 << 28;

// What both ends have learnt.
struct SurfaceModel {
  static constexpr size_t kScales = 16;
  std::array<NumberModel, kScales> displacement;
  std::array<NumberModel, kScales> normal;
  std::array<NumberModel, 2> radius, along, cone, bulge;  // without parents, with
  std::array<NumberModel, 16> across;
  EscapeModel escape;
};

// The server's end.
class SurfaceEncoder final : public NodeSource<SurfaceBatch> {
 public:
  SurfaceEncoder(const SurfaceDomain& domain, std::span<const glm::ivec3> base, std::span<const SurfaceRecord> records,
                 SurfaceModel& model, RangeEncoder& coder)
      : domain_(domain), base_(base), records_(records), model_(model), coder_(coder) {}
  RadiusClass radius(Slot) override { return {}; }
  void onAddable(int level, std::span<const Slot> slots) override;
  void load(SurfaceBatch& batch) override;
  bool answer(int, std::span<const Question> questions, std::span<uint8_t>) override { return questions.empty(); }
  uint64_t sent() const { return sent_; }  // records

 private:
  const SurfaceDomain& domain_;
  std::span<const glm::ivec3> base_;
  std::span<const SurfaceRecord> records_;
  SurfaceModel& model_;
  RangeEncoder& coder_;
  uint64_t sent_ = 0;
};

// The records that a client holds of one object.
using SurfaceRecords = std::unordered_map<Slot, SurfaceRecord>;

// The client's end: reads into `records` as an adapter steps.
class SurfaceDecoder final : public NodeSource<SurfaceBatch> {
 public:
  SurfaceDecoder(const SurfaceDomain& domain, std::span<const glm::ivec3> base, SurfaceRecords& records,
                 SurfaceModel& model, RangeDecoder& coder)
      : domain_(domain), base_(base), records_(records), model_(model), coder_(coder) {}
  RadiusClass radius(Slot) override { return {}; }
  void onAddable(int level, std::span<const Slot> slots) override;
  void load(SurfaceBatch& batch) override;
  bool answer(int, std::span<const Question> questions, std::span<uint8_t>) override { return questions.empty(); }
  bool onAdded(int, std::span<const Slot>, std::span<const ErrorClass>) override { return !isBroken(); }
  // The bytes were no delta for these sections.
  bool isBroken() const { return absurd_ || coder_.overrun(); }

 private:
  const SurfaceDomain& domain_;
  std::span<const glm::ivec3> base_;
  SurfaceRecords& records_;
  SurfaceModel& model_;
  RangeDecoder& coder_;
  bool absurd_ = false;
};

}  // namespace foreland::proto
