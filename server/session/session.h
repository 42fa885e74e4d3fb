// Session is the state machine that serves one viewer: messages and times go in, messages come out. A session has no
// socket, clock or thread inside, so the server's I/O thread, the pool and the tests' virtual world can all drive it.
//
// A session is owned by its host or by exactly one worker at a time, and is never locked. Server times may be of any
// monotonic clock; times of the client's clock say so in their names.
//
// A session is the thin owner of its parts. What the viewer has said is kept by input/; pure functions plan when the
// next keyframe is due (plan/) and which view it is for (view/); server/section sends the section's changes, and
// server/imagery the tiles. No keyframe is sent in part.
#pragma once

#include <algorithm>
#include <deque>
#include <functional>
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
#include "server/session/plan/occlusion_control.h"
#include "server/session/plan/prefetch_pace.h"
#include "server/session/view/keyframe_view.h"
#include "server/session/world.h"

namespace foreland::server {

struct SessionOptions {
  // A viewer that asks for no tolerance gets this one.
  double tau_px = 1;
  // A viewer that asks for no interval gets this one. An interval of 100 ms costs 5 % more bytes and draws 11 % fewer
  // triangles; one of 500 ms costs 7 % fewer and draws 24 % more (docs/LATENCY.md).
  Duration keyframe_interval = Duration::milliseconds(200);
  // A viewer that asks for no interval gets intervals up to this one; 0 keeps them fixed.
  Duration longest_interval{};
  // A predicted keyframe should arrive this long before it is needed. No measurement of the value is recorded. It hides
  // that a keyframe is a few milliseconds late (decision 0024), and makes every pose older by as much.
  Duration safety = Duration::milliseconds(15);
  // The tolerance of a section is raised until the section has at most this many nodes, objects included. The limit is
  // twelve times what a section has at 1080p and 1 px (THEORY section 6); no measurement of it is recorded.
  size_t max_section_nodes = 1'500'000;
  // One keyframe adds at most this many nodes, so that no step takes long, and the next keyframes add the rest: a
  // section at 1080p and 1 px fits twice. The first keyframe after a jump of the camera is wanted at once, so it adds
  // fewer; with this limit `foreland fly --tour jumps` was at its tolerance again after at most 630 ms.
  size_t max_added_nodes = 250'000, max_added_after_jump = 40'000;
  // The pages that will be needed this much later are read in advance, for scenes larger than memory; 0 turns that off.
  Duration prefetch_ahead{};
  // A viewer may remember at most this many bytes of terrain; the server needs a fortieth of them for the viewer. No
  // measurement of the limit is recorded; it is four times what clients ask for unless told otherwise.
  uint32_t max_memory_bytes = 64u << 20;
  // A predicted keyframe may be computed this much before it must be begun, but never by more than half an interval.
  Duration max_early{};
  // Where max_early permits it, a predicted keyframe is always begun this much early: it may cost more than the last
  // ones did, or wait for another that was begun before. Decision 0024 weighs 0, 4, 15 and 30 ms against older poses.
  Duration slack = Duration::milliseconds(30);
  // The tiles that a viewer may hold take at most this many bytes.
  uint32_t max_tile_bytes = proto::kDefaultTileBytes;
  // At most this many keyframes are sent and not yet acknowledged; more would only queue in the link. The value is the
  // protocol's (docs/PROTOCOL.md, section 13): at 200 ms it covers round trips of 1.6 s.
  size_t max_unacknowledged = 8;
  // What a world that can leave out what is hidden does about it.
  Occlusion occlusion = Occlusion::kOn;
  // OcclusionControl::next() takes this rank of the viewer.
  double occlusion_rank = 0;
  // Makes what takes the place of the predictor that the viewer asks for, unless that is a known path; empty: nothing.
  std::function<std::unique_ptr<Foresight>()> foresee{};
};

// Each worker has one SessionScratch, and lends it to the step that it runs.
struct SessionScratch {
  SendScratch send;
};

// Numbers count from the start of the session, unless a comment names the last keyframe.
struct SessionStatistics {
  uint64_t keyframes = 0;
  uint64_t skipped_keyframes = 0;  // No keyframe was sent for so many points of the grid.
  uint64_t nodes_added = 0, nodes_removed = 0;
  uint64_t nodes_tested = 0;  // Keyframes made so many exact tests of terrain nodes,
  uint64_t nodes_swept = 0;   // and swept so many entries of frontiers (proto/refine/sweep.h).
  // So many nodes were found only to be counted: of sections that were refined from scratch, and of samples of some.
  uint64_t nodes_measured = 0;
  size_t section_nodes = 0;  // The last keyframe's section has so many nodes.
  // The viewer knows so many nodes of the terrain beside those around the last keyframe's section.
  size_t remembered_nodes = 0;
  // The server holds so many bytes to know which nodes the viewer remembers, and what ridges hide from it.
  size_t memory_bytes = 0;
  OcclusionStatistics occlusion;
  Duration occlusion_time{};  // Occlusion took so long, by what its work costs on a usual machine.
  size_t hidden_objects = 0;  // So many objects were hidden in the last keyframe.
  bool is_occluding = false;  // What is hidden was left out of the last keyframe.
  size_t left_out_nodes = 0;  // The last comparison (Occlusion::kAuto) found so many nodes left out.
  // Occlusion was withdrawn so often for want of room, and of use.
  uint64_t occlusion_shed = 0, occlusion_worthless = 0;
  uint64_t prefetches = 0;
  uint64_t replies = 0;                // So many requests were answered.
  uint64_t jumps = 0;                  // The camera's jumps were recognised (proto/space/jump.h) or announced.
  double tau_px = 0;                   // The last keyframe has this tolerance.
  bool is_coarse = false;              // The last keyframe's tolerance is larger than the viewer asked for.
  bool is_lacking = false;             // Likewise, because of pages that are not there, of a scene at a distance.
  uint64_t tiles = 0, tile_bytes = 0;  // So many tiles were sent.
  bool resumed = false;  // The session started from a section that the viewer held from an earlier connection.
};

class Session {
 public:
  Session(std::shared_ptr<const World> world, const SessionOptions& options);

  // Takes one message from the viewer. An Error means: send a Refusal with its message, then close.
  Status receive(ByteSpan message, Time now);

  // The time from which the session has something to do, and the deadline for it (earliest deadline first). The result
  // is empty while the session waits for messages.
  std::optional<Due> due() const;

  // Does the one thing that is due at `now`: computes a keyframe, answers a request, takes in a section to resume from,
  // or prefetches. Whole messages are appended to `out`. A call before due() does nothing. The caller reports the time
  // that the step took to noteComputeTime(). Requests get at most a fifth of a worker's time, and no request is
  // answered while an earlier reply is unsent.
  //
  // A keyframe costs one adaptation. One refinement from scratch is added if the viewer limits its bytes, or if the
  // section may exceed a limit of nodes: it is the first one, follows a jump, or has more than half the limit. If it
  // does exceed the limit, about four refinements are added (toleranceThatFits), most of which end early. A guessed
  // region that outgrows what was observed takes some more (RegionShare::fit).
  // A keyframe is computed as late as it can be, so that it uses the newest pose. Start::kEarly computes it from
  // Due::earliest on, for the sake of other viewers whose keyframes are due at the same time.
  enum class Start : uint8_t { kWhenDue, kEarly };
  void step(Time now, SessionScratch& scratch, std::vector<Bytes>& out, Start start = Start::kWhenDue);
  // Takes in how long the last step took, and how many of the scene's pages it read from the disk.
  void noteComputeTime(Duration spent, uint64_t pages_read = 0);
  // The time that a keyframe is expected to take.
  Duration computeTime() const { return state_.compute_time; }
  // Answers no request before `until`. Hosts call it when they have no room for a reply.
  void postponeReplies(Time until) { next_request_ = std::max(next_request_, until); }
  // The bytes that the viewer can make the server keep for as long as it likes: of what waits for an answer
  // (ViewerInput), and of answers that are not sent. O(requests).
  size_t keptBytes() const;
  // Says what the server's processors can give this viewer from now on, and for which share of the viewers they find
  // out what is hidden.
  void setProcessors(Processors processors, double occlusion_share = 1) {
    processors_ = processors;
    occlusion_share_ = occlusion_share;
  }

  // Must be called once the transport has sent every byte of earlier steps. No keyframe is computed before that, so at
  // most one delta waits to be sent.
  void onDrained(Time now);

  const World& world() const { return *world_; }
  const SessionStatistics& statistics() const { return statistics_; }
  // The terrain's section that the client holds once it has read everything that was sent; it is keyframe()'s.
  proto::Section section() const { return sender_.adapter().section(); }
  // The pages of terrain that the client knows once it has read everything that was sent, ascending.
  std::vector<proto::KnownPage> knownPages() const { return sender_.adapter().knownPages(); }
  const proto::KeyframeHeader& keyframe() const { return sender_.keyframe(); }
  // The result is null before the welcome, and always if the scene has no tiles.
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
  // Whether keyframes can be made: there is a pose, and what is seen from there has a size.
  bool canSee() const { return hasPose() && !input_.request().showsNothing(); }
  std::optional<Time> heldKeyframe() const;
  void acknowledge(const proto::PoseUpdate& update);

  std::optional<KeyframePlan> plan() const;
  void aim();
  std::optional<Due> requestDue() const;
  std::optional<Due> prefetchDue() const;
  std::optional<Due> comparisonDue() const;
  void answer(std::vector<Bytes>& out);
  void tryToResume();
  void prefetch(SessionScratch& scratch);

  // These functions make a keyframe (session_keyframes.cpp).
  struct Keyframe {
    Time time_client;
    Duration until_next;  // The next keyframe is at most this much later.
    proto::View view;
    RegionParts parts;  // of its region
  };
  void computeKeyframe(const KeyframePlan& plan, SessionScratch& scratch, std::vector<Bytes>& out);
  bool isCoarserThanWanted() const;
  Keyframe viewOf(Time t, SessionScratch& scratch);
  void moveGround(const Keyframe& keyframe);
  bool sendKeyframe(Keyframe keyframe, size_t max_nodes, SessionScratch& scratch, Bytes& message);
  void sendWithTiles(Bytes message, const Keyframe& keyframe, std::vector<Bytes>& out);
  void notePredictions(const Keyframe& keyframe);
  double eyeError(Duration until_next) const;
  ViewerOcclusion* visibilityFor(const Keyframe& keyframe);
  size_t nodesToCompare() const;
  void compareOcclusion(SessionScratch& scratch);
  void count(const KeyframePlan& plan, const SessionScratch& scratch);
  void countOcclusion();

  // These functions limit the size of a keyframe's section (session_limits.cpp).
  double sectionTolerance() const;
  size_t maxNodes() const;
  void fitBudget(proto::View& view, SessionScratch& scratch);
  double maxAddedForLink() const;
  double loadOf(const proto::View& view, SessionScratch& scratch);
  bool isRegionGuessed() const;
  void fitRegion(proto::View view, const RegionParts& parts, SessionScratch& scratch);
  void observeRegion(const RegionParts& parts, SessionScratch& scratch);

  std::shared_ptr<const World> world_;
  SessionOptions options_;
  ViewerInput input_;
  KeyframeState state_;
  std::optional<Time> target_;  // aim() chose this grid point of the client's clock.
  AdaptiveInterval adaptive_interval_;
  std::vector<Bytes> replies_;  // The next step sends these.
  Time next_request_;           // No request is answered before.
  enum class Did : uint8_t { kNothing, kKeyframe, kRequest, kPrefetch, kComparison };
  Did did_ = Did::kNothing;  // The last step did this.
  Processors processors_ = Processors::kFree;
  double occlusion_share_ = 1;

  SectionSender sender_;
  std::unique_ptr<ViewerOcclusion> occlusion_;  // The pointer is null if the welcome promised no hidden blocks.
  std::unique_ptr<TileSender> tiles_;           // See tiles().
  OcclusionControl occlusion_control_;
  Duration occlusion_observed_{};  // occlusion_control_ has taken in so much of statistics_.occlusion_time.
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
