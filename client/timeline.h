// Timeline decides which mesh is shown when (THEORY section 4). A keyframe mesh spans the times [from.time, to.time] of
// the path. It is shown during an interval of the client's clock that begins where the interval of the mesh before it
// ends, so the display never jumps. The strategy says which interval:
//   predict         shows the mesh from from.time to to.time: geometry and clock agree, and nothing is delayed
//   delay, current  show it later by T + playout delay. T is the keyframe interval of the paper's formula for t_d. The
//                   playout delay is the recent latency of link and server (0 in the paper, where server and client are
//                   one). After an outage the display catches up at once instead of replaying it: the excess of T over
//                   the shortest recent interval (over the interval that was asked for, if there is no recent one) and
//                   that of the playout delay over the least recent latency are together at most kLongestDelay
//                   (base/latency.h). Where intervals adapt, T is the longest that there may be, lest the display stand
//                   still before each long one
// A mesh of n + 1 keyframes shows the times that its keyframes blend to, which are in the middle of them
// (EarlierKeyframes), so for such a mesh T counts (n + 1) / 2 times. A mesh that does not move shows a section that was
// sent whole: the section is the first one, or the camera has jumped, or a new server could not resume. Such a mesh is
// shown on arrival, and the meshes before it are dropped, since their guarantees hold elsewhere. A mesh that follows it
// within less than an interval and is finer is shown on arrival, too. A mesh that arrives
// late begins on arrival and still ends in time, but lasts at least kShortestBlend. When no keyframe has arrived for
// kTimeout, the host extends the transitions that are not over, by kExtension at a time. One owner; times are those of
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
  // An extension costs as much as a keyframe's mesh. Made as soon as a keyframe was late, extensions made the client
  // later still: 10 keyframes in 10 s on a busy machine, and 50 with these values.
  static constexpr Duration kTimeout = Duration::milliseconds(500);
  static constexpr Duration kExtension = Duration::milliseconds(250);
  // If the host has stopped drawing, only the newest kMaxUndrawn meshes are kept, and the host applies the patches of
  // the dropped ones (DrawnMesh::skipTo); no measurement of the value is recorded. If the host draws, up to kMaxMeshes
  // meshes are kept, since dropping a mesh that is shown would make the display jump. At intervals of 100 ms the
  // playout delay holds 20 meshes (kLongestDelay), and after a stall all unacknowledged keyframes, 8 at most, arrive
  // between two frames.
  static constexpr size_t kMaxUndrawn = 8;
  static constexpr size_t kMaxMeshes = 32;

  // Sets the interval that is asked for from the next mesh on.
  void setInterval(const proto::KeyframeInterval& interval) { interval_ = interval; }

  // Schedules the mesh that a keyframe completed. The result is how much later than the time from which it was to be
  // shown the mesh arrived: negative if it was early, and 0 for the first mesh and for one that does not move.
  Duration add(std::shared_ptr<const MeshPatch> mesh, Time arrival, proto::Strategy strategy);

  // Schedules a mesh that extends transitions for kExtension after the newest mesh, which must exist.
  void extend(std::shared_ptr<const MeshPatch> mesh);

  // The versions of the oldest and the newest mesh that are kept; 0 if there is none.
  uint32_t oldestVersion() const { return schedule_.size() == 0 ? 0 : schedule_.front().version; }
  uint32_t newestVersion() const { return schedule_.size() == 0 ? 0 : schedule_.back().version; }
  // The newest mesh's interval, valid until the next call of a member; nullptr if there is no mesh.
  const Interval* newest() const { return schedule_.size() == 0 ? nullptr : &schedule_.back(); }

  // Drops all meshes, so nothing is shown until the next one is added. Versions are not reused.
  void clear() { restart(); }

  struct Shown : Schedule::Shown {
    const MeshPatch* mesh = nullptr;  // The pointer is valid until the next call of a member; nullptr shows nothing.
    uint32_t version = 0;             // The mesh's version ascends from mesh to mesh, and 0 stands for none.
  };
  // Finds what to show at `now`, which must not decrease, and drops the meshes whose interval has ended.
  Shown at(Time now);

 private:
  // The T by which the mesh is delayed.
  Duration intervalOf(const MeshPatch& mesh);
  void restart();
  void push(std::shared_ptr<const MeshPatch> mesh, Time begin, Time end);
  Duration playoutExcess() const;
  void updatePlayoutDelay(const MeshPatch& mesh, Time arrival);

  Schedule schedule_;
  std::deque<std::shared_ptr<const MeshPatch>> meshes_;  // Each interval of the schedule has its mesh here.
  std::deque<Duration> intervals_;                       // Recent meshes had these intervals.
  std::deque<Duration> latencies_;                       // Recent keyframes had these values of arrival - to.time.
  Duration playout_delay_;
  proto::KeyframeInterval interval_;
  size_t undrawn_ = 0;  // So many meshes were added since the last call of at().
  uint32_t next_version_ = 1;
};

}  // namespace foreland::client
