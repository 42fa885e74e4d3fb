// What bounds.h computes, where deep pages are there or not (proto/section/page_directory.h): the true surface is that
// of all nodes that are there. Between them it is as even as the triangles of the finest mesh that they make, so what a
// node's support holds of it is known by its nodes alone, and a node that is not there adds nothing to errors. How far
// that surface lies from what it was made of is for others to state.
//
// Time and memory are those of the nodes that are there, not of the lattice; what a node takes stands in
// sparse_errors.h.
#pragma once

#include <functional>
#include <span>

#include "proto/section/node_tables.h"
#include "proto/section/page_directory.h"
#include "proto/space/frame.h"

namespace foreland::terrain {

struct SparseBoundsJob {
  const proto::GridTopology& grid;
  const proto::Frame& frame;
  const proto::PageDirectory& pages;
  proto::BaseHeights base;
  // The height of a node whose page is there, quanta, less than proto::kMaxHeight either way; beyond the data that of
  // the nearest sample. From any thread, once for each node, page by page.
  std::function<int32_t(proto::NodeId)> height;
  std::span<proto::NodeRecord> records;  // by place; zeros at first
  unsigned threads = 0;                  // 0: one per processor
  // Called on the calling thread with the fraction done. False stops the work.
  std::function<bool(double)> onProgress = [](double) { return true; };
};

// Fills the records. False if `onProgress` stopped it. The result does not depend on the number of threads.
[[nodiscard]] bool computeSparseBounds(const SparseBoundsJob& job);

}  // namespace foreland::terrain
