// ViewerObjects holds, from keyframe to keyframe, which objects of a scene are proved to be hidden from one viewer, by
// ridges (horizon.h) or by other objects (object_solids.h). An object that is hidden stays its base mesh: its nodes are
// neither tested nor sent. Which it is needs no word to the client, who is told of changes of objects' sections alone.
//
// Proofs are for spans of intervals, as those of blocks (span_proof.h), but for fewer eyes (PathSpans::kTight): a query
// costs a hundredth of what a horizon does, and what hides something from a whole street is rare. Queries are cut to
// capsules of kMaxPiece_m. Only what is in view is tried, and has nodes, or will have some because it is large on the
// screen. A keyframe makes kMaxQueries at most, as many as a first view of some thousand objects takes; what is left is
// visible.
//
// One owner (a ViewerOcclusion). The results depend on the calls alone.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <vector>

#include "proto/refine/metric/frustum.h"
#include "server/occlusion/objects/object_solids.h"
#include "server/occlusion/proofs/span_proof.h"

namespace foreland::server {

// Whether a solid of an object hides a target from a capsule of eyes, however long: cut to pieces, each of which one
// solid must hide it from. `hint` is a solid that may do; it becomes one that did. Counts queries.
bool hideFrom(const ObjectSolids& solids, const EyeCapsule& eyes, std::span<const glm::dvec3> target, double rho_m,
              uint32_t& hint, uint64_t& queries);

class ViewerObjects {
 public:
  static constexpr double kMaxPiece_m = 16;
  static constexpr uint64_t kMaxQueries = 4000;
  static constexpr size_t kFewestNodes = 16;  // that are worth a query

  // Both must outlive it; `solids` are of `objects`.
  ViewerObjects(const SceneObjects& objects, const ObjectSolids& solids)
      : objects_(objects), solids_(solids), states_(objects.set.size()) {}

  // Whether ridges hide the hull of points from all eyes of a span.
  using BehindRidge = std::function<bool(const PathSpan&, std::span<const glm::dvec3>, Towards)>;
  // What a keyframe needs; referred to until the next one.
  struct Keyframe {
    const proto::View& view;
    const proto::Frustum& frustum;
    SpanProver prover;
    const EyeIntervals& intervals;
    BehindRidge behind_ridge;
    // Whether an object is to turn visible since proofs fade; empty: none.
    std::function<bool(size_t object)> has_faded;
  };
  void begin(Keyframe keyframe);

  // Whether an object whose section has so many nodes is hidden. Once for each object in a keyframe.
  bool isHidden(size_t object, size_t nodes);

  uint64_t queries() const { return queries_; }  // since the start
  size_t hiddenInView() const { return hidden_in_view_; }
  void forget();
  size_t bytes() const { return states_.capacity() * sizeof(State); }

 private:
  struct State {
    SpanProof proof;
    int32_t next = 0;
    uint32_t hint = ObjectSolids::kNone;  // the solid that hid it last
    bool is_hidden = false;
  };

  bool isWorth(size_t object, size_t nodes) const;
  bool hides(size_t object, State& state, PathSpan& span, Towards towards);

  const SceneObjects& objects_;
  const ObjectSolids& solids_;
  std::vector<State> states_;
  std::optional<Keyframe> now_;
  uint64_t queries_ = 0, last_query_ = 0;
  size_t hidden_in_view_ = 0;
};

}  // namespace foreland::server
