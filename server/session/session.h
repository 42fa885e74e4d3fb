// One viewer's state machine: messages and times in, messages out. It has no socket, clock or thread inside, so that
// the server's I/O thread, the pool and the tests' virtual world can all drive the same code.
//
// A session is owned by its host or by exactly one worker at a time, and never locked. Server times are of any
// monotonic clock; times of the client's clock say so in their names.
//
// Keyframes lie on a grid of the client's clock, T apart (DESIGN section 4). With `predict`, the keyframe for t_{i+1}
// is computed so that it arrives by t_i; with `delay` and `current`, that for t_i is computed when the pose of t_i has
// arrived. A viewer that blends n + 1 keyframes shows what is in the middle of them (leadOf), so with `predict` its
// keyframes are computed (n - 1) / 2 intervals sooner, and a region holds for so much longer either way. If viewer,
// link or server cannot keep up, grid points are skipped; no keyframe is sent in part.
#pragma once

#include <algorithm>
#include <deque>
#include <memory>
#include <optional>
#include <vector>

#include "base/bytes.h"
#include "base/result.h"
#include "proto/message/message.h"
#include "server/imagery/tile_sender.h"
#include "server/section/budget.h"
#include "server/section/sender.h"
#include "server/session/adaptive_interval.h"
#include "server/session/announced_jumps.h"
#include "server/session/clock_map.h"
#include "server/session/prefetch_pace.h"
#include "server/session/requests.h"
#include "server/session/scene_time.h"
#include "server/session/world.h"
#include "server/view/viewer_motion.h"

namespace foreland::server {

struct SessionOptions {
  double tau_px = 1;                                         // for viewers that ask for no tolerance
  Duration keyframe_interval = Duration::milliseconds(200);  // for viewers that ask for none
  Duration longest_interval{};                               // the same; 0: it is fixed
  Duration safety = Duration::milliseconds(15);  // a predicted keyframe should arrive this long before it is needed
  // The tolerance of a section is raised until it has at most this many nodes, objects included.
  size_t max_section_nodes = 1'500'000;
  // One keyframe adds at most this many, so that no step takes long; the next ones add the rest. Fewer in the first
  // keyframe after the camera jumped, which is wanted at once.
  size_t max_added_nodes = 250'000, max_added_after_jump = 40'000;
  Duration prefetch_ahead{};  // reads what will be needed this much later, for scenes larger than memory; 0: never
  uint32_t max_memory_bytes = 64u << 20;  // that a viewer may remember; the server needs a fortieth of that for it
  Duration max_early{};  // a predicted keyframe may be computed so much earlier than it must be begun, but at most
                         // half an interval
  // Where that is permitted it is always begun so much earlier, for it may cost more than the last ones did, or wait
  // for another that was begun before (decision 0056).
  Duration slack = Duration::milliseconds(15);
  uint32_t max_tile_bytes = proto::kDefaultTileBytes;  // of tiles that a viewer may hold
  size_t max_unacknowledged = 8;  // keyframes sent and not yet acknowledged; more would only queue in the link
};

// Working memory that a worker lends to a step; one per worker, reused.
struct SessionScratch {
  SendScratch send;
};

struct SessionStatistics {
  uint64_t keyframes = 0;
  uint64_t skipped_keyframes = 0;  // grid points without a keyframe
  uint64_t nodes_added = 0, nodes_removed = 0;
  uint64_t nodes_tested = 0;    // of the terrain, by keyframes
  uint64_t nodes_measured = 0;  // of sections that were refined from scratch to be counted
  size_t section_nodes = 0;
  size_t remembered_nodes = 0;    // of the terrain, that the viewer knows beside those around its section
  size_t memory_bytes = 0;        // that the server needs to know which, and what ridges hide
  OcclusionStatistics occlusion;  // of this connection
  uint64_t prefetches = 0;
  uint64_t replies = 0;                // to requests
  uint64_t jumps = 0;                  // of the camera, recognised (proto/space/jump.h) or announced
  double tau_px = 0;                   // in force
  bool is_coarse = false;              // that is above what the viewer asked for
  uint64_t tiles = 0, tile_bytes = 0;  // sent
  bool resumed = false;                // started from a section that the viewer held from an earlier connection
};

class Session {
 public:
  Session(std::shared_ptr<const World> world, const SessionOptions& options);

  // Takes one message from the viewer. An Error means: send a Refusal with its message, then close.
  Status receive(ByteSpan message, Time now);

  // When the session has something to do, and by when it should be done (earliest deadline first); nothing if it waits
  // for messages.
  struct Due {
    Time release;
    Time deadline;
    bool is_costly = false;          // no keyframe, and may take up to a second
    Duration work{};                 // that a keyframe is expected to take; 0 for anything else
    std::optional<Time> earliest{};  // from when a keyframe may be computed early, that is with Start::kEarly
  };
  std::optional<Due> due() const;

  // Does what is due at `now`: one keyframe, or one reply to a request, or what a section to resume from takes, or one
  // prefetch. Appends whole messages to `out`. Called early, it does nothing. Report afterwards how long it took with
  // noteComputeTime: requests are answered with at most a fifth of a worker's time, and none while an earlier reply is
  // unsent.
  //
  // Cost of a keyframe: one adaptation. If the section may exceed a limit of nodes (the first one, one after a jump, or
  // one of more than half the limit), or the viewer limits its bytes, one refinement from scratch as well; if the
  // section then is too large, about four (toleranceThatFits), most of which end early. A guessed region that outgrows
  // what was observed takes some more (RegionShare::fit).
  // A keyframe is computed as late as it can be, for then it uses the newest pose; Start::kEarly computes it from
  // Due::earliest on, for the sake of others who are due at the same time.
  enum class Start : uint8_t { kWhenDue, kEarly };
  void step(Time now, SessionScratch& scratch, std::vector<Bytes>& out, Start start = Start::kWhenDue);
  // And how many pages of the scene it had to read from the disk.
  void noteComputeTime(Duration spent, uint64_t pages_read = 0);
  // How long a keyframe is expected to take.
  Duration computeTime() const { return compute_time_; }
  // Answers no request before `until`, since there is no room for the reply.
  void postponeReplies(Time until) { next_request_ = std::max(next_request_, until); }
  // What the viewer makes the server keep, as long as it likes: its announced path, requests that wait, a section to
  // resume from. O(requests).
  size_t keptBytes() const;
  // What the server's processors can give this viewer from now on.
  void setProcessors(Processors processors) { processors_ = processors; }

  // To be called when the transport has sent every byte of earlier steps. Until then no keyframe is computed, so at
  // most one delta waits to be sent.
  void onDrained(Time now);

  const World& world() const { return *world_; }
  const SessionStatistics& statistics() const { return statistics_; }
  // The terrain's section that the client holds once it has read everything sent, and the keyframe it belongs to.
  proto::Section section() const { return sender_.adapter().section(); }
  // What the client knows of the terrain once it has read everything sent, ascending.
  std::vector<proto::KnownPage> knownPages() const { return sender_.adapter().knownPages(); }
  const proto::KeyframeHeader& keyframe() const { return sender_.keyframe(); }
  // Null if the scene has no tiles.
  const TileSender* tiles() const { return tiles_.get(); }

 private:
  Status take(const proto::ViewRequest& request, Time now);
  Status take(const proto::Path& path, Time now);
  Status take(const proto::TourRequest& request, Time now);
  Status take(const proto::GroundRequest& request, Time now);
  Status take(const proto::SceneClock& clock, Time now);
  Status take(const proto::HeldTiles& held, Time now);
  Status take(const proto::PoseUpdate& update, Time now);
  Status take(const proto::Resume& resume, Time now);

  // The keyframe to compute next: its time on the client's clock, and when to begin and to be done.
  struct Plan {
    Time time_client;
    Due due;
    uint64_t skipped;
    Duration until_next;  // the keyframe after it is at most this much later
  };
  std::optional<Plan> plan() const;
  Time earliestKeyframe() const;
  Plan notTooSoon(Plan plan) const;
  // With `predict`: chooses the grid point that the next keyframe is for, and keeps to it until that keyframe would be
  // late by more than half an interval.
  void aim();
  Time nextKeyframe() const;
  proto::KeyframeInterval bounds() const { return {request_->keyframe_interval, request_->longest_interval}; }
  // Whether no keyframe has been sent on this connection.
  bool isFirst() const { return statistics_.keyframes == 0; }
  bool isAnnouncedJump(const proto::PoseUpdate& update, Time now);
  void jumpTo(const proto::TimedPose& pose);
  bool isTooFarAhead() const;
  Time gridAtOrAfter(Time t_client) const;
  // How long before and after its time a keyframe is shown, in part, if keyframes are an interval apart.
  Duration leadOf(Duration interval) const { return {interval.us * (request_->order + 1) / 2}; }
  Time shownFrom(Time t) const;
  void moveGround(Time t_client, const proto::View& view);
  double sectionTolerance() const;
  // For a keyframe that is shown until the next one, which is `until_next` later.
  RegionParts regionFor(Time t_client, Duration until_next) const;
  proto::View viewFor(Time t_client, const RegionParts& parts) const;
  size_t maxNodes() const;
  std::optional<Due> requestDue() const;
  std::optional<Due> prefetchDue() const;
  void answer(std::vector<Bytes>& out);
  void tryToResume();
  void prefetch(SessionScratch& scratch);
  void fitBudget(proto::View& view, SessionScratch& scratch);
  double maxAddedForLink() const;
  double loadOf(const proto::View& view, SessionScratch& scratch);
  bool sendKeyframe(proto::View view, const Plan& plan, size_t max_nodes, SessionScratch& scratch, Bytes& message);
  bool isRegionGuessed() const;
  void fitRegion(proto::View view, const RegionParts& parts, SessionScratch& scratch);
  void observeRegion(SessionScratch& scratch);
  void sendWithTiles(Bytes message, const Plan& plan, const proto::View& view, std::vector<Bytes>& out);
  void computeKeyframe(Plan plan, Time now, SessionScratch& scratch, std::vector<Bytes>& out);

  std::shared_ptr<const World> world_;
  SessionOptions options_;
  std::optional<proto::ViewRequest> request_;
  ViewerMotion motion_;
  SceneTime scene_time_;
  ClockMap clocks_;
  bool jumped_ = false;  // and no keyframe has been computed since
  AnnouncedJumps announced_jumps_;
  proto::PoseMemory poses_taken_;
  Time now_;                    // of the last event
  std::optional<Time> target_;  // the grid point that aim() chose, the client's clock
  Duration interval_;           // from the last keyframe to the next
  Duration last_step_;          // from the keyframe before the last one to that
  AdaptiveInterval adaptive_interval_;
  std::vector<Bytes> replies_;  // ready
  Requests requests_;
  Time next_request_;  // not to be answered earlier
  std::optional<proto::Resume> resume_;
  bool resumed_ = false;  // or tried to
  enum class Did : uint8_t { kNothing, kKeyframe, kRequest, kPrefetch };
  Did did_ = Did::kNothing;  // in the last step
  Processors processors_ = Processors::kFree;

  SectionSender sender_;
  std::unique_ptr<ViewerOcclusion> occlusion_;  // null if deltas on this connection carry no hidden blocks
  std::unique_ptr<TileSender> tiles_;           // null until the viewer wants some that the scene has
  ToleranceControl tolerance_;
  bool unsent_ = false;
  uint32_t acknowledged_ = 0;
  Time last_keyframe_at_, keyframe_before_last_at_;  // when they were computed
  bool was_after_jump_ = false;
  struct Sent {
    uint32_t index;
    Time at;
  };
  std::deque<Sent> in_flight_;
  Duration compute_time_ = Duration::milliseconds(10);  // of the slower of the recent keyframes
  PrefetchPace prefetch_pace_;
  SessionStatistics statistics_;
};

}  // namespace foreland::server
