// Between which heights each vertex stays, at whatever scene time: its height, in a scene that does not change. What is
// blended in time lies between them, and so does what is drawn between two keyframes. Immutable; any thread.
//
// Memory: eight bytes a vertex of the part of the data that moves. Construction is O(offsets).
#pragma once

#include <cstdint>
#include <vector>

#include "server/section/hierarchy.h"

namespace foreland::server {

class HeightBounds {
 public:
  // `hierarchy` must outlive it.
  explicit HeightBounds(const Hierarchy& hierarchy);

  // Quanta, of any vertex of the lattice. Beyond the data they are those of the nearest sample.
  int32_t lowest(proto::NodeId v) const { return table_.height(v) + riseOf(v).least; }
  int32_t highest(proto::NodeId v) const { return table_.height(v) + riseOf(v).most; }

 private:
  struct Rise {
    int32_t least = 0, most = 0;
  };
  const Rise* at(proto::NodeId v) const;
  Rise riseOf(proto::NodeId v) const {
    const Rise* rise = at(v);
    return rise ? *rise : Rise{};
  }

  proto::DenseNodes table_;
  uint32_t last_x_, last_y_;     // of the data
  proto::LatticeWindow moving_;  // holds all that moves
  std::vector<Rise> rises_;      // of its samples, row by row
};

}  // namespace foreland::server
