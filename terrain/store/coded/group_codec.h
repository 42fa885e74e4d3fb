// Pages of a scene as few bits: groups of kGroupPages pages, each coded by the wire's adaptive range coder
// (proto/codec) with what is known of a node's neighbours on coarser levels as context. Lossless for any records: a
// page that is not as the builder makes pages is kept as it is.
//
//   height   its difference from what a quadratic surface through the neighbours would have, as in deltas; beyond the
//            data, from what the builder makes it
//   error    whether it is 0; if not, its distance from the least that the node's own displacement allows, given what
//            its parents' errors allow
//   radius   one for each page
//
// What follows from these and from the grid is not coded: displacements, and slots that name no node. A group needs the
// records of groups before it only, for places ascend with levels. Decoders accept any bytes and say whether these were
// a group. Pure; any thread; no allocation but the encoder's output.
#pragma once

#include <cstdint>
#include <memory>
#include <span>

#include "base/bytes.h"
#include "proto/section/node_tables.h"
#include "proto/section/page_directory.h"
#include "proto/topology/grid.h"
#include "terrain/store/coded/group_reader.h"
#include "terrain/store/coded/page_model.h"

namespace foreland::terrain {

inline constexpr uint64_t kGroupPages = 16;
inline constexpr uint64_t kGroupRecords = kGroupPages * proto::kPageSlots;
inline constexpr uint64_t kGroupBytes = kGroupRecords * sizeof(proto::NodeRecord);

inline uint64_t groupCount(uint64_t pages) { return (pages + kGroupPages - 1) / kGroupPages; }

// The terrain whose pages are coded. Views, which must outlive it.
struct CodedTerrain {
  const proto::GridTopology& grid;
  const proto::PageDirectory& directory;
  std::span<const proto::NodeRecord> records;  // by place; of the groups before the one that is decoded
  proto::BaseHeights base;
  const proto::Frame& frame;

  // The places of a group's records.
  uint64_t firstOf(uint64_t group) const { return group * kGroupRecords; }
  uint64_t countOf(uint64_t group) const;
};

// Appends a group to `out`. `model` must have been started, and is used up. Who encodes looks at `records` alone, not
// at terrain.records; the group is worth nothing if these cannot be read.
void encodeGroup(const CodedTerrain& terrain, GroupReader& records, uint64_t group, PageModel& model, Bytes& out);

// Into countOf(group) records. False if the bytes are no group; `out` then holds some records or others.
[[nodiscard]] bool decodeGroup(const CodedTerrain& terrain, uint64_t group, ByteSpan bytes, PageModel& model,
                               std::span<proto::NodeRecord> out);

// Counts what the groups of a terrain would code, which says where models had best start. One owner.
class ModelTrainer {
 public:
  ModelTrainer();
  ~ModelTrainer();
  void add(const CodedTerrain& terrain, GroupReader& records, uint64_t group);
  ModelStart start() const;

 private:
  struct Counts;
  std::unique_ptr<Counts> counts_;
};

}  // namespace foreland::terrain
