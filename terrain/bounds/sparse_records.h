// The records of ground that is fine in places while they are being made: found by node, gone over level by level in
// pieces of pages, for coarse levels have few pages, whose nodes take long. A view; any thread.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "proto/section/node_tables.h"
#include "proto/section/page_directory.h"

namespace foreland::terrain {

class SparseRecords {
 public:
  static constexpr uint64_t kNowhere = proto::PageDirectory::kNowhere;
  struct Page {
    proto::Slot first;
    uint64_t place;  // of the record of its first slot
  };

  SparseRecords(const proto::GridTopology& grid, const proto::PageDirectory& pages, proto::BaseHeights base,
                std::span<proto::NodeRecord> records)
      : grid_(grid),
        pages_(pages),
        base_(base),
        records_(records),
        by_level_(static_cast<size_t>(grid.maxLevel()) + 1) {
    pages.forEachPage([&](proto::Slot first, uint64_t place) {
      by_level_[static_cast<size_t>(grid.pagePlace(first).level)].push_back({first, place * proto::kPageSlots});
    });
  }

  std::span<const Page> pagesOf(int level) const { return by_level_[static_cast<size_t>(level)]; }
  uint64_t pieceCount(int level) const { return pagesOf(level).size() * kPieces; }
  // Calls visit(node, place of its record) for the nodes of a piece of a level, without padding.
  template <class Visit>
  void forEachNode(int level, uint64_t piece, const Visit& visit) const {
    const Page& page = pagesOf(level)[piece / kPieces];
    const auto nodes = grid_.pageNodes(level, page.first);
    const auto begin = static_cast<uint32_t>(piece % kPieces * kPieceSlots);
    for (uint32_t low = begin; low < begin + kPieceSlots; ++low)
      if (const proto::NodeId n = nodes.at(low); grid_.contains(n)) visit(n, page.place + low);
  }

  // kNowhere if the node's page is not there.
  uint64_t placeOf(proto::NodeId n, int level) const { return pages_.placeOf(grid_.slot(n, level)); }
  proto::NodeRecord& operator[](uint64_t place) const { return records_[place]; }
  uint64_t size() const { return records_.size(); }
  // Of a base vertex, or of a node whose page is there.
  int32_t heightOf(proto::NodeId v) const {
    const int level = grid_.level(v);
    return level == 0 ? base_.at(grid_, v) : records_[placeOf(v, level)].height();
  }

 private:
  static constexpr uint32_t kPieces = 16;  // of a page
  static constexpr uint32_t kPieceSlots = proto::kPageSlots / kPieces;

  const proto::GridTopology& grid_;
  const proto::PageDirectory& pages_;
  proto::BaseHeights base_;
  std::span<proto::NodeRecord> records_;
  std::vector<std::vector<Page>> by_level_;
};

}  // namespace foreland::terrain
