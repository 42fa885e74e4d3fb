// The nodes whose weight is on its way, of a terrain or of one object: which they are, and how far they have come.
//
// A surface is drawn with a weight w(v) for each node (DESIGN section 2): 1 in the section, 0 outside it, and between
// where a node comes or goes (S 3.5, equation 6). A mesh spans an interval; its `from` and `to` are the surfaces with
// the weights at its two ends, so a weight runs evenly within a mesh and has its corners where meshes meet. A change
// lasts a whole number of intervals, by its own clock; with one interval for all, this is the blend of two keyframes.
// What starts or turns round starts from the weight that it has, so the surface that ends a mesh is the one that begins
// the next: what is drawn depends on the weights alone, not on the mesh that draws it. A change of no length is a jump
// at the mesh's beginning, for what is not seen.
//
// The nodes drawn at either end are those with a weight and all their parents: closed, so they are sections like
// others, and a node that goes stays until its children have gone. One owner; O(changing nodes) a step, but for
// look-ups.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <span>
#include <vector>

#include "base/check.h"
#include "proto/section/section.h"

namespace foreland::client {

// Bits: drawn at a mesh's beginning, at its end.
inline constexpr uint8_t kInFrom = 1, kInTo = 2;

struct Morph {
  proto::Slot slot = 0;
  bool comes = false;       // it is of the section; or else it goes
  uint8_t in = 0;           // kInFrom | kInTo
  double from = 0, to = 0;  // weights at the mesh's ends

  double goal() const { return comes ? 1 : 0; }
  bool isDone() const { return to == goal(); }
};

// The weights at a mesh's ends of a node that is not on its way, by the bits above.
inline std::array<double, 2> weightsOf(uint8_t in) { return {in & kInFrom ? 1.0 : 0.0, in & kInTo ? 1.0 : 0.0}; }

// Of ascending ones; nullptr if the node is not among them. O(log n).
inline const Morph* findMorph(std::span<const Morph> morphs, proto::Slot slot) {
  const auto at = std::lower_bound(morphs.begin(), morphs.end(), slot,
                                   [](const Morph& m, proto::Slot wanted) { return m.slot < wanted; });
  return at != morphs.end() && at->slot == slot ? &*at : nullptr;
}

class Morphs {
 public:
  // To the next mesh, with the change of the section, if any. `lengthOf(slot)` is how many intervals a node takes for
  // the whole way, or 0 if it may jump; asked once of each node on its way, which then is in the section, or drawn.
  template <class Topology, class LengthOf>
  void step(const Topology& topology, const proto::CutDelta& change, const LengthOf& lengthOf) {
    begin(change);
    bool are_whole = true;
    for (Morph& m : all_) {
      advance(m, lengthOf(m.slot));
      are_whole = are_whole && m.from == 1 - m.goal() && m.isDone();
    }
    mark(kInFrom, &Morph::from);
    mark(kInTo, &Morph::to);
    if (!are_whole) {  // or else those drawn are the sections before and after, which are closed
      close(topology, kInFrom);
      close(topology, kInTo);
    }
    compare();
  }

  // Ascending. Every other node has weight 1 in the section and 0 outside it.
  std::span<const Morph> all() const { return all_; }
  // Whether any has not reached its goal at the mesh's end.
  bool isUnderWay() const {
    return std::any_of(all_.begin(), all_.end(), [](const Morph& m) { return !m.isDone(); });
  }
  // The nodes drawn at the mesh's beginning against those at the last one's end, and those at its end against those at
  // its beginning.
  const proto::CutDelta& jumped() const { return jumped_; }
  const proto::CutDelta& drawn() const { return drawn_; }
  // The section, of the nodes that are drawn at the mesh's end.
  proto::Section sectionOf(proto::Section drawn) const;

 private:
  void begin(const proto::CutDelta& change);
  static void advance(Morph& m, double intervals);
  void compare();
  // Who has a weight is drawn.
  void mark(uint8_t bit, double Morph::*weight) {
    for (Morph& m : all_)
      if (m.*weight > 0) m.in |= bit;
  }
  // And so are its parents. Slots ascend with the level.
  template <class Topology>
  void close(const Topology& topology, uint8_t bit) {
    for (size_t i = all_.size(); i-- > 0;) {
      const Morph& m = all_[i];
      if (!(m.in & bit) || (m.comes && bit == kInTo)) continue;  // what is in the section has its parents there
      for (proto::NodeId parent : topology.parents(topology.node(m.slot)))
        if (const Morph* p = findMorph(std::span(all_).first(i), topology.slot(parent)))
          all_[static_cast<size_t>(p - all_.data())].in |= bit;
    }
  }

  std::vector<Morph> all_, merged_;
  std::vector<proto::Slot> was_drawn_;  // of `all_`, at the last mesh's end
  proto::CutDelta jumped_, drawn_;
};

}  // namespace foreland::client
