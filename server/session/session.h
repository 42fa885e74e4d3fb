// One viewer's state machine: messages and times in, messages out. It has no socket, clock or thread inside, so that
// the server's I/O thread, the pool and the tests' virtual world can all drive the same code.
//
// A session is owned by its host or by exactly one worker at a time, and never locked. Server times are of any
// monotonic clock; times of the client's clock say so in their names.
//
// It is the thin owner of its parts: what the viewer has said (input/), when the next keyframe is due (plan/, pure),
// for which view (view/, pure), what of the section is sent (server/section), and which tiles (server/imagery). No
// keyframe is sent in part.
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
#include "server/session/input/viewer_input.h"
#include "server/session/plan/adaptive_interval.h"
#include "server/session/plan/keyframe_plan.h"
#include "server/session/plan/prefetch_pace.h"
#include "server/session/view/keyframe_view.h"
#include "server/session/world.h"

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
  // for another that was begun before (decision 0024).
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
  Duration computeTime() const { return state_.compute_time; }
  // Answers no request before `until`, since there is no room for the reply.
  void postponeReplies(Time until) { next_request_ = std::max(next_request_, until); }
  // What the viewer makes the server keep, as long as it likes: what waits for an answer (ViewerInput), and answers
  // that are not sent. O(requests).
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
  Status take(const proto::SightRequest& request, Time now);
  Status take(const proto::ViewshedRequest& request, Time now);
  Status take(const proto::RequestCancel& request, Time now);
  Status take(const proto::SceneClock& clock, Time now);
  Status take(const proto::HeldTiles& held, Time now);
  Status take(const proto::PoseUpdate& update, Time now);
  Status take(const proto::Resume& resume, Time now);
  proto::Welcome welcome();
  void advance(Time now) { state_.now = std::max(state_.now, now); }
  bool hasPose() const { return input_.hasGreeted() && !input_.motion().empty(); }
  std::optional<Time> heldKeyframe() const;
  void acknowledge(const proto::PoseUpdate& update);

  std::optional<KeyframePlan> plan() const;
  void aim();
  std::optional<Due> requestDue() const;
  std::optional<Due> prefetchDue() const;
  void answer(std::vector<Bytes>& out);
  void tryToResume();
  void prefetch(SessionScratch& scratch);

  // How a keyframe is made (session_keyframes.cpp).
  struct Keyframe {
    Time time_client;
    Duration until_next;  // the keyframe after it is at most this much later
    proto::View view;
  };
  void computeKeyframe(const KeyframePlan& plan, SessionScratch& scratch, std::vector<Bytes>& out);
  Keyframe viewOf(Time t, SessionScratch& scratch);
  void moveGround(const Keyframe& keyframe);
  bool sendKeyframe(Keyframe keyframe, size_t max_nodes, SessionScratch& scratch, Bytes& message);
  void sendWithTiles(Bytes message, const Keyframe& keyframe, std::vector<Bytes>& out);
  void notePredictions(const Keyframe& keyframe);
  void count(const KeyframePlan& plan, const SessionScratch& scratch);

  // How large its section may be (session_limits.cpp).
  double sectionTolerance() const;
  size_t maxNodes() const;
  void fitBudget(proto::View& view, SessionScratch& scratch);
  double maxAddedForLink() const;
  double loadOf(const proto::View& view, SessionScratch& scratch);
  bool isRegionGuessed() const;
  void fitRegion(proto::View view, const RegionParts& parts, SessionScratch& scratch);
  void observeRegion(SessionScratch& scratch);

  std::shared_ptr<const World> world_;
  SessionOptions options_;
  ViewerInput input_;
  KeyframeState state_;
  std::optional<Time> target_;  // the grid point that aim() chose, the client's clock
  AdaptiveInterval adaptive_interval_;
  std::vector<Bytes> replies_;  // ready
  Time next_request_;           // not to be answered earlier
  enum class Did : uint8_t { kNothing, kKeyframe, kRequest, kPrefetch };
  Did did_ = Did::kNothing;  // in the last step
  Processors processors_ = Processors::kFree;

  SectionSender sender_;
  std::unique_ptr<ViewerOcclusion> occlusion_;  // null if deltas on this connection carry no hidden blocks
  std::unique_ptr<TileSender> tiles_;           // null until the viewer wants some that the scene has
  ToleranceControl tolerance_;
  bool unsent_ = false;
  uint32_t acknowledged_ = 0;
  struct Sent {
    uint32_t index;
    Time at;
  };
  std::deque<Sent> in_flight_;
  PrefetchPace prefetch_pace_;
  SessionStatistics statistics_;
};

}  // namespace foreland::server
