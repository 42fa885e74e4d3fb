// The ground of a scene's nodes at any point of its lattice, also of one that is fine in places only. A view of nodes
// and base heights, which must outlive it; immutable; any thread.
#pragma once

#include <optional>
#include <span>

#include "proto/section/bounds.h"
#include "proto/section/node_tables.h"
#include "proto/section/page_directory.h"
#include "proto/topology/grid.h"
#include "terrain/store/distant/page_supply.h"

namespace foreland::terrain {

class StoredHeights {
 public:
  // `records` by place in the directory. With a supply not all of its pages are there.
  StoredHeights(const proto::GridTopology& grid, const proto::PageDirectory& pages,
                std::span<const proto::NodeRecord> records, proto::BaseHeights base, const PageSupply* supply = nullptr)
      : grid_(grid), pages_(pages), records_(records), base_(base), supply_(supply) {}

  // Height of any lattice point, node or base vertex, in quanta. Where no page is, the ground is the triangle of the
  // finest nodes around that are there, and the height is its nearest whole number of quanta there: some five look-ups,
  // with a supply one for each level.
  int32_t at(proto::NodeId v) const;
  // The same without rounding to whole quanta.
  double exactAt(proto::NodeId v) const;

  const proto::GridTopology& grid() const { return grid_; }
  const proto::PageDirectory& pages() const { return pages_; }

 private:
  // Of a node of this level that is not there.
  double interpolated(proto::NodeId v, int level) const;
  // Nothing if the page is not there.
  std::optional<int32_t> heightAt(proto::Slot slot) const;

  const proto::GridTopology& grid_;
  const proto::PageDirectory& pages_;
  std::span<const proto::NodeRecord> records_;
  proto::BaseHeights base_;
  const PageSupply* supply_;
};

}  // namespace foreland::terrain
