// Which mesh is shown when (DESIGN section 4). Each keyframe mesh spans the scene times [from.time, to.time]; it is
// shown during an interval of the client's clock that begins where the previous one ends, so what is drawn never jumps:
//   predict          from from.time to to.time: geometry and clock agree, nothing is delayed
//   delay, current   the same, later by T + lambda: T is the keyframe interval of the paper's formula for t_d, and lambda is what the
//                    link and the server add to it (0 in the paper, where the server is the client); T is at most kLongestDelay
//                    (base/latency.h) above the shortest recent one, so an outage is caught up with, not shown at length
// A mesh that arrives late begins when it is there and still ends in time, if need be after kShortestBlend. When no
// keyframe has come for kTimeout, nodes that are on their way go on, a kExtension at a time; not sooner, for that costs
// what a keyframe's mesh costs, and a client that is late for those must not be made later. One owner; times are the
// client's clock.
#pragma once

#include <deque>
#include <memory>

#include "base/time.h"
#include "client/keyframe_mesh.h"

namespace foreland::client {

class Timeline {
 public:
  static constexpr Duration kShortestBlend = Duration::milliseconds(50);
  static constexpr Duration kTimeout = Duration::milliseconds(500);
  static constexpr Duration kExtension = Duration::milliseconds(250);
  static constexpr size_t kMaxMeshes = 8;

  // Takes the mesh that a keyframe completed. Returns how late it came for the time from which it was to be shown;
  // negative is early.
  Duration add(std::shared_ptr<const KeyframeMesh> mesh, Time arrival, proto::Strategy strategy);

  // Shows a mesh that no keyframe brought for kExtension, after the last one.
  void extend(std::shared_ptr<const KeyframeMesh> mesh);

  // Shows nothing until the next mesh comes; versions go on.
  void clear() {
    entries_.clear();
    intervals_.clear();
    latencies_.clear();
  }

  struct Shown {
    const KeyframeMesh* mesh = nullptr;
    double weight = 0;
    Time scene_time;
    uint32_t version = 0;
    bool is_over = false;  // and there is none after it
  };
  // What to show at `now`; drops meshes that are over. `now` does not decrease.
  Shown at(Time now);

 private:
  struct Entry {
    std::shared_ptr<const KeyframeMesh> mesh;
    Time begin, end;  // the client's clock
    uint32_t version;
  };
  // T of the mesh.
  Duration intervalOf(const KeyframeMesh& mesh);
  void updatePlayoutDelay(const KeyframeMesh& mesh, Time arrival);

  std::deque<Entry> entries_;
  std::deque<Duration> intervals_;  // of recent meshes
  std::deque<Duration> latencies_;  // arrival - to.time of recent keyframes
  Duration playout_delay_;
  uint32_t next_version_ = 1;
};

}  // namespace foreland::client
