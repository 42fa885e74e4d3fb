// The nodes in transition of a terrain or of one object: which they are, and how far each has morphed.
//
// A surface is drawn with a weight w(v) for each node (THEORY section 2): 1 if the node is in the section, 0 if not,
// and between while it is added or removed (S 3.5, equation 6). A mesh is shown for one interval; its `from` and `to`
// are the surfaces with the weights at its two ends, so a weight is linear within a mesh and may change its slope where
// meshes meet. A transition takes a whole number of intervals, which per-node morph timing chooses; if that is one for
// every node, this is the blend of two keyframes. A transition that starts or reverses starts from the weight that the
// node has, so a mesh begins with the surface that the last one ended with: what is drawn depends on the weights alone.
// A transition of no length is a jump at the mesh's beginning, for what is not seen. Where n + 1 keyframes are blended
// (blend.h), the weight at a mesh's end is the spline's, and it comes to rest n intervals after the last change.
//
// The nodes drawn at either end are those with a weight above 0 and all their ancestors: parent-closed, so they are
// sections like others, and a removed node is drawn until its children's transitions are over. One owner; a step costs
// O(nodes in transition), but for look-ups.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <span>
#include <vector>

#include "base/check.h"
#include "client/mesh/weights/spline.h"
#include "proto/section/section.h"

namespace foreland::client {

// Bits: drawn at a mesh's beginning, drawn at its end.
inline constexpr uint8_t kInFrom = 1, kInTo = 2;

// A node in transition.
struct Morph {
  proto::Slot slot = 0;
  bool is_added = false;    // it is in the newest section, so its weight grows to 1; otherwise it falls to 0
  uint8_t in = 0;           // kInFrom | kInTo
  double from = 0, to = 0;  // weights at the mesh's ends
  uint8_t history = 0;      // of which of the last keyframes' sections it is a node; bit 0: of the newest

  bool wasIn(uint32_t keyframes_ago) const { return (history >> keyframes_ago & 1) != 0; }
  // Where more keyframes are blended: its weight's controls between the mesh's ends (spline.h).
  std::array<double, 2> controls(uint32_t order) const {
    return splineControls(order, from, to, [this](uint32_t i) { return wasIn(i) ? 1.0 : 0.0; });
  }
  double goal() const { return is_added ? 1 : 0; }
  bool isDone() const { return to == goal(); }
};

// The weights at a mesh's ends of a node that is in no transition, by the bits above.
inline std::array<double, 2> weightsOf(uint8_t in) { return {in & kInFrom ? 1.0 : 0.0, in & kInTo ? 1.0 : 0.0}; }

// Finds a node among `morphs`, which ascend by slot; nullptr if it is not there. O(log n).
inline const Morph* findMorph(std::span<const Morph> morphs, proto::Slot slot) {
  const auto at = std::lower_bound(morphs.begin(), morphs.end(), slot,
                                   [](const Morph& m, proto::Slot wanted) { return m.slot < wanted; });
  return at != morphs.end() && at->slot == slot ? &*at : nullptr;
}

class Morphs {
 public:
  // Steps to the next mesh. `change` is what the section changes by, which is nothing between keyframes.
  // `lengthOf(slot)` is how many intervals the way from 0 to 1 takes, 0 for a jump; it is called once for each node in
  // transition, which then is in the section or drawn. With an `order` above 1 the way follows from the last sections
  // that the node was in or out of, and only whether the length is 0 counts.
  template <class Topology, class LengthOf>
  void step(const Topology& topology, const proto::CutDelta& change, const LengthOf& lengthOf, uint32_t order = 1) {
    begin(change);
    bool from_before = true, from_after = true, to_after = true;
    for (Morph& m : all_) {
      advance(m, lengthOf(m.slot), order);
      from_before = from_before && m.from == 1 - m.goal();
      from_after = from_after && m.from == m.goal();
      to_after = to_after && m.isDone();
    }
    mark(kInFrom, &Morph::from);
    mark(kInTo, &Morph::to);
    // The sections before and after the change are closed.
    if (!from_before && !from_after) close(topology, kInFrom);
    if (!to_after) close(topology, kInTo);
    compare();
  }

  // The nodes in transition, by ascending slot. Every other node has weight 1 in the section and 0 outside it.
  std::span<const Morph> all() const { return all_; }
  // Whether some node's transition is not over when the mesh ends.
  bool isInTransition() const {
    return std::any_of(all_.begin(), all_.end(), [](const Morph& m) { return !m.isDone(); });
  }
  // How the set of drawn nodes changes from the last mesh's end to this one's beginning, by jumps.
  const proto::CutDelta& jumped() const { return jumped_; }
  // How it changes from this mesh's beginning to its end.
  const proto::CutDelta& drawn() const { return drawn_; }
  // The newest section, from the nodes that are drawn at the mesh's end: those that are not being removed.
  proto::Section sectionOf(proto::Section drawn) const;

 private:
  void begin(const proto::CutDelta& change);
  static void advance(Morph& m, double intervals, uint32_t order);
  void compare();
  // Nodes with a weight are drawn.
  void mark(uint8_t bit, double Morph::*weight) {
    for (Morph& m : all_)
      if (m.*weight > 0) m.in |= bit;
  }
  // The parents of drawn nodes are drawn. One pass from the end suffices, for slots ascend with the level.
  template <class Topology>
  void close(const Topology& topology, uint8_t bit) {
    for (size_t i = all_.size(); i-- > 0;) {
      const Morph& m = all_[i];
      if (!(m.in & bit) || (m.is_added && bit == kInTo)) continue;  // a node of the section has its parents there
      for (proto::NodeId parent : topology.parents(topology.node(m.slot)))
        if (const Morph* p = findMorph(std::span(all_).first(i), topology.slot(parent)))
          all_[static_cast<size_t>(p - all_.data())].in |= bit;
    }
  }

  std::vector<Morph> all_, merged_;
  std::vector<proto::Slot> was_drawn_;  // those of `all_` that were drawn at the last mesh's end
  proto::CutDelta jumped_, drawn_;
};

}  // namespace foreland::client
