// Decides which mesh is shown when (THEORY section 4). A keyframe mesh spans the times [from.time, to.time] and
// is shown during an interval of the client's clock that begins where that of the mesh before it ends, so what is drawn
// never jumps:
//   predict         from from.time to to.time: geometry and clock agree, and nothing is delayed
//   delay, current  the same, later by T + playout delay. T is the keyframe interval of the paper's formula for t_d; the
//                   playout delay is the recent latency of link and server (0 in the paper, where server and client are
//                   one). T counts for more than the shortest recent interval, or than the one asked for where there was
//                   none, and the playout delay for more than the least recent latency: by at most kLongestDelay
//                   (base/latency.h) together, so after an outage the display catches up at once instead of replaying
//                   it. Where intervals adapt, T is the longest that there may be, lest the display stand still before
//                   each long one
// A mesh of n + 1 keyframes shows what is in the middle of them, the times that its keyframes blend to
// (EarlierKeyframes), and T counts (n + 1) / 2 times. A mesh that does not move shows a section that was sent whole: it
// is the first one, or the camera has jumped, or a new server could not resume. It is shown on arrival, and the meshes
// before it are dropped, for what they guarantee is about elsewhere. A mesh that arrives late begins on arrival and
// still ends in time, but lasts at least kShortestBlend. When no keyframe has arrived for kTimeout, the host extends
// the transitions that are not over, by kExtension at a time. It does not do so sooner because an extension costs as
// much as a keyframe's mesh, and must not make a client that is late for keyframes later still. One owner; times are
// the client's clock.
#pragma once

#include <deque>
#include <memory>

#include "base/time.h"
#include "client/mesh/patch/blend_patch.h"
#include "client/schedule.h"
#include "proto/message/keyframe_interval.h"

namespace foreland::client {

class Timeline {
 public:
  static constexpr Duration kShortestBlend = Schedule::kShortestBlend;
  static constexpr Duration kTimeout = Duration::milliseconds(500);
  static constexpr Duration kExtension = Duration::milliseconds(250);
  // For a host that has stopped drawing the newest kMaxUndrawn meshes are kept; it applies the patches of those that
  // are not (DrawnMesh::skipTo). One that draws keeps them all, up to kMaxMeshes: the playout delay may hold
  // kLongestDelay of them, and after a stall all that were on their way arrive between two frames. To drop one that is
  // shown would make the display jump.
  static constexpr size_t kMaxUndrawn = 8;
  static constexpr size_t kMaxMeshes = 32;

  // That is asked for, from the next mesh on.
  void setInterval(const proto::KeyframeInterval& interval) { interval_ = interval; }

  // Schedules the mesh that a keyframe completed. Returns how late it arrived for the time from which it was to be
  // shown; negative is early, and 0 is returned for the first mesh and for one that does not move.
  Duration add(std::shared_ptr<const MeshPatch> mesh, Time arrival, proto::Strategy strategy);

  // Schedules a mesh that extends transitions, for kExtension after the last one. There must have been a mesh.
  void extend(std::shared_ptr<const MeshPatch> mesh);

  // Of the meshes that are kept; 0 if there are none.
  uint32_t oldestVersion() const { return schedule_.size() == 0 ? 0 : schedule_.front().version; }
  uint32_t newestVersion() const { return schedule_.size() == 0 ? 0 : schedule_.back().version; }
  // The newest one's interval; nullptr if there is none. Valid until the next call of a member.
  const Interval* newest() const { return schedule_.size() == 0 ? nullptr : &schedule_.back(); }

  // Shows nothing until the next mesh is added. Versions are not reused.
  void clear() { restart(); }

  struct Shown : Schedule::Shown {
    const MeshPatch* mesh = nullptr;  // nullptr if there is none; valid until the next call of a member
    uint32_t version = 0;             // of the mesh; ascends, never 0
  };
  // What to show at `now`, which must not decrease. Drops meshes whose interval has ended.
  Shown at(Time now);

 private:
  // The interval T that the mesh is delayed by.
  Duration intervalOf(const MeshPatch& mesh);
  void restart();
  void push(std::shared_ptr<const MeshPatch> mesh, Time begin, Time end);
  Duration playoutExcess() const;
  void updatePlayoutDelay(const MeshPatch& mesh, Time arrival);

  Schedule schedule_;
  std::deque<std::shared_ptr<const MeshPatch>> meshes_;  // of the schedule's intervals
  std::deque<Duration> intervals_;                       // of recent meshes
  std::deque<Duration> latencies_;                       // arrival - to.time, of recent keyframes
  Duration playout_delay_;
  proto::KeyframeInterval interval_;
  size_t undrawn_ = 0;  // meshes added since at() was called last
  uint32_t next_version_ = 1;
};

}  // namespace foreland::client
