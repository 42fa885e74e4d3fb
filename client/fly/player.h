// The headless player: a host of the Viewer that flies a tour or a track frame by frame. Bytes and times in, bytes and
// what to draw out; sockets and clocks belong to whoever drives it, so the same flight can be flown over a network or
// in virtual time.
//
// The stages of a flight: greeting, until the server's welcome arrives; planning, while a tour or ground heights are
// requested; standing at the first pose, until the first section is there; flying; done. The player's input is
// recorded. A replay of the record gives the same frames bit by bit, so measuring and dumping happen after the flight
// and do not disturb it. One owner.
#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "client/fly/exaggeration.h"
#include "client/fly/jump_tour.h"
#include "client/fly/track_path.h"
#include "client/fly/tracks/track.h"
#include "client/viewer.h"

namespace foreland::client {

enum class PathKnowledge : uint8_t {
  kAnnounced,
  kPrivate
};  // kAnnounced: the server knows the path (predictor kKnownPath)

struct PlayerOptions {
  proto::ViewRequest request;
  Blend blend = Blend::kKeyframe;
  PathKnowledge knowledge = PathKnowledge::kPrivate;
  // A person steers: there is no plan, and each frame brings its camera (Player::steer).
  bool is_steered = false;
  std::string tour = "survey";  // used if there is no track; `jumps` is planned here, others by the server
  std::shared_ptr<const Track> track;
  TrackOptions track_options;
  // If its factor is not 1, the request is for its asked lens and finer tolerance, tours and tracks are flown by the
  // camera of the picture, and what is shown are asked poses. Not for `jumps` and steered flights.
  Exaggeration exaggeration{};
  // In scenes with epochs: from which scene time and at which rate the flight goes through scene time, from its
  // beginning; SceneClock::at does not count.
  std::optional<proto::SceneClock> scene{};
  bool has_meshes = true;  // false: flown for keyframes alone, as by many viewers at once; nothing is drawn
  double seconds = 60;     // of the flight; on a track, track_options.seconds is used instead
  Duration standing = Duration::milliseconds(1000);   // least time at the first pose
  Duration timeout = Duration::milliseconds(10'000);  // longest wait for a reply, or for the first section
};

// What the one who steers a flight may change on the way.
struct ViewChoice {
  proto::ViewRequest request;
  Blend blend = Blend::kKeyframe;
};

// A player's input, in order.
struct FlightLog {
  enum class What : uint8_t { kFrame, kMessage, kReconnect, kSteered, kChoice, kJump };
  struct Entry {
    Time time;
    What what = What::kFrame;
    Bytes message{};                             // of kMessage
    proto::Pose pose{};                          // of kSteered
    std::shared_ptr<const ViewChoice> choice{};  // of kChoice
  };
  PlayerOptions options;
  std::vector<Entry> entries;
};

struct FlightReport {
  uint64_t frames = 0;  // shown while flying
  uint64_t frames_without_mesh = 0;
  double seconds = 0;                         // flown
  uint32_t nodes = 0;                         // of the newest section shown
  size_t triangles = 0;                       // of the newest mesh shown
  double mean_nodes = 0, mean_triangles = 0;  // over frames with a mesh
  uint32_t keyframes_flying = 0, late_keyframes_flying = 0;
  uint64_t frames_outside = 0;    // drawn from where one of the two keyframes does not guarantee its tolerance
  Duration longest_gap;           // between the arrivals of two keyframes, while flying
  std::vector<JumpReport> jumps;  // by kind; empty for other tours
  std::optional<Time> scene_first, scene_last;  // shown, in scenes with epochs
  ViewerStatistics session;                     // everything since the connection
};

class Player {
 public:
  enum class Phase : uint8_t { kGreeting, kPlanning, kStanding, kFlying, kDone };

  // `flown`: in a replay of a flight that was steered, where the camera was.
  explicit Player(PlayerOptions options, proto::Path flown = {});

  // Takes a message from the server. An Error ends the flight: show it to the user and disconnect. The report stays
  // valid.
  Status receive(ByteSpan message, Time now);
  // The connection was lost and there is a new one. The flight continues, or is planned again if it had not begun.
  void reconnect(Time now);
  // Draws one frame. Times must not decrease; 60 frames a second are customary.
  Status frame(Time now);
  // The same of a flight that is steered, with the camera at `pose`. It flies from the welcome on, until the log ends.
  void steer(Time now, const proto::Pose& pose);
  // The camera of the next frame that is steered will have jumped there (Viewer::jump).
  void jump(Time now);
  // What a steered flight asks for from now on.
  void choose(Time now, const ViewChoice& choice);
  bool takeOutgoing(Bytes& message) { return viewer_.takeOutgoing(message); }

  Phase phase() const { return phase_; }
  // What the last frame showed; valid until the next frame. Its mesh may be nullptr.
  const FrameView& view() const { return view_; }
  // The camera's planned path on the client's clock; valid from kStanding on. Of a tour of jumps, its beginning and end
  // only; of a flight that is steered, only in a replay.
  const proto::Path& path() const { return path_; }
  const Viewer& viewer() const { return viewer_; }
  FlightReport report() const;
  const std::vector<std::string>& notes() const { return notes_; }
  const FlightLog& log() const { return log_; }

 private:
  Status plan();
  Status takePlan(Time now);
  Status takeGround(Time now);
  void askGround();
  bool hasGroundToAsk() const { return log_.options.track != nullptr || jumps_; }
  const std::vector<glm::dvec2>& groundPositions() const { return jumps_ ? jumps_->positions() : planned_.positions; }
  Status planJumps();
  Status startJumps(Time now);
  void startScene();
  proto::Pose camera(Time now) const;
  void tellJump(Time now);
  void countJump(Time now);
  Status setPath(proto::Path path, Time now);
  void note(const std::vector<std::string>& notes) { notes_.insert(notes_.end(), notes.begin(), notes.end()); }
  void enter(Phase phase, Time now);
  Status checkTimeout(Time now) const;
  void countFrame();
  void countGap(Time now, uint32_t keyframes_before);

  FlightLog log_;
  Viewer viewer_;
  Phase phase_ = Phase::kGreeting;
  std::optional<Time> phase_start_;
  FrameView view_;
  proto::Path path_;
  PlannedTrack planned_;
  std::optional<JumpTour> jumps_;
  JumpReports jump_reports_;
  size_t flown_view_ = 0;  // of the tour of jumps
  std::vector<float> ground_m_;
  std::vector<std::string> notes_;
  FlightReport report_;
  ViewerStatistics before_flight_;
  Time keyframe_at_;  // when the last one arrived
  double node_sum_ = 0, triangle_sum_ = 0;
};

// Where a replay ended.
struct Replayed {
  Player player;
  Status status;  // the Error that ended it before the log did
};

// Flies a recorded flight again. `onFrame` is called after each frame with the player and the frame's time; it may stop
// the replay by returning false.
Replayed replay(const FlightLog& log, const std::function<bool(const Player&, Time)>& on_frame);

}  // namespace foreland::client
