// One viewer's state machine: messages and times in, messages out. No socket, clock or thread inside: the server's I/O
// thread, the pool and the tests' virtual world all drive the same code.
//
// Owned by whoever holds it: its host, or exactly one worker at a time; never locked. Server times are any monotonic
// clock; the client's clock appears only where a name says so.
//
// Keyframes lie on a grid of the client's clock, T apart (DESIGN section 4). `predict` computes the one at t_{i+1} so
// that it is there at t_i; `delay` and `current` compute the one at t_i when the pose of t_i is there. Whoever cannot
// keep up skips grid points; each keyframe that is sent is whole.
#pragma once

#include <deque>
#include <memory>
#include <optional>
#include <vector>

#include "base/bytes.h"
#include "base/result.h"
#include "proto/message/message.h"
#include "server/section/budget.h"
#include "server/section/sender.h"
#include "server/session/clock_map.h"
#include "server/session/world.h"
#include "server/view/pose_history.h"
#include "server/view/prediction_errors.h"
#include "server/view/region.h"

namespace foreland::server {

struct SessionOptions {
  double tau_px = 1;                                         // for viewers that name none
  Duration keyframe_interval = Duration::milliseconds(200);  // for viewers that name none
  Duration safety = Duration::milliseconds(15);  // a predicted keyframe aims to be there this long before it is needed
  size_t max_section_nodes = 1'500'000;          // beyond it the tolerance is doubled until the section fits
  Duration prefetch_ahead{};      // touch what will be needed this much later, for scenes larger than memory; 0: do not
  size_t max_unacknowledged = 8;  // keyframes on their way; more would only queue in the link
};

// What a worker brings to a step; one per worker, reused.
struct SessionScratch {
  SendScratch send;
};

struct SessionStatistics {
  uint64_t keyframes = 0;
  uint64_t skipped_keyframes = 0;  // grid points passed over
  uint64_t nodes_added = 0, nodes_removed = 0;
  size_t section_nodes = 0;
  uint64_t prefetches = 0;
  bool resumed = false;  // from a section that the viewer presented
};

class Session {
 public:
  Session(std::shared_ptr<const World> world, const SessionOptions& options);

  // Takes one message from the viewer. An Error means: send a Refusal with its message, then close.
  Status receive(ByteSpan message, Time now);

  // When there is something to do, and by when it should be done (earliest deadline first). Nothing: wait for messages.
  struct Due {
    Time release;
    Time deadline;
  };
  std::optional<Due> due() const;

  // Does what is due at `now`: hands over replies, and computes at most one keyframe. Appends whole messages to `out`.
  // Called early, it does nothing. Cost: one adaptation. Tell afterwards how long it took with noteComputeTime.
  void step(Time now, SessionScratch& scratch, std::vector<Bytes>& out);
  void noteComputeTime(Duration spent);

  // The transport has handed on every byte of earlier steps; until then no keyframe is computed (at most one unsent
  // delta).
  void onDrained(Time now);

  const World& world() const { return *world_; }
  const SessionStatistics& statistics() const { return statistics_; }
  // What the client holds once it has read everything sent; and the keyframe that it belongs to.
  proto::Section section() const { return sender_.adapter().section(); }
  const proto::KeyframeHeader& keyframe() const { return sender_.keyframe(); }

 private:
  Status take(const proto::ViewRequest& request, Time now);
  Status take(const proto::Path& path, Time now);
  Status take(const proto::TourRequest& request, Time now);
  Status take(const proto::GroundRequest& request, Time now);
  Status take(const proto::PoseUpdate& update, Time now);
  Status take(const proto::Resume& resume, Time now);

  // The keyframe to compute next: its time on the client's clock, and when to begin and to be done.
  struct Plan {
    Time time_client;
    Due due;
    uint64_t skipped;
  };
  std::optional<Plan> plan() const;
  // With `predict`: chooses the grid point to aim at, and keeps to it until it is hopelessly late.
  void aim();
  // No keyframe has been sent on this connection.
  bool isFirst() const { return statistics_.keyframes == 0; }
  Time gridAtOrAfter(Time t_client) const;
  ExpectedMotion expectedMotion() const;
  proto::View viewFor(Time t_client) const;
  size_t mostNodes() const;
  std::optional<Due> prefetchDue() const;
  void prefetch(SessionScratch& scratch);
  void fitBudget(proto::View& view, SessionScratch& scratch);
  bool isThroughInTime(const proto::View& view, SessionScratch& scratch) const;
  void computeKeyframe(const Plan& plan, Time now, SessionScratch& scratch, std::vector<Bytes>& out);

  std::shared_ptr<const World> world_;
  SessionOptions options_;
  std::optional<proto::ViewRequest> request_;
  PoseHistory history_;
  PredictionErrors prediction_errors_;
  std::deque<proto::TimedPose> predictions_;  // not yet overtaken by true poses
  std::optional<proto::Path> path_;
  ClockMap clocks_;
  proto::PoseMemory poses_taken_;
  Time now_;                    // of the last event
  std::optional<Time> target_;  // grid point aimed at with `predict`, the client's clock
  std::vector<Bytes> replies_;

  SectionSender sender_;
  ToleranceControl tolerance_;
  bool unsent_ = false;
  uint32_t acknowledged_ = 0;
  struct Sent {
    uint32_t index;
    Time at;
  };
  std::deque<Sent> in_flight_;
  Duration compute_time_ = Duration::milliseconds(10);  // a high recent value
  Time next_prefetch_;
  SessionStatistics statistics_;
};

}  // namespace foreland::server
