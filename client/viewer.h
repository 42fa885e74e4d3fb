// The client's whole side of a session: bytes and times in, bytes and meshes out. No socket, no clock, no thread
// inside; the headless player (client/fly), the page (client/wasm) and the virtual world of the tests are thin hosts of
// it. One owner. Times are the client's clock: microseconds since an epoch that the host chooses, the same one for its
// whole life.
#pragma once

#include <deque>
#include <memory>
#include <optional>
#include <vector>

#include "client/blend.h"
#include "client/keyframe_mesh.h"
#include "client/replica.h"
#include "client/timeline.h"
#include "proto/message/message.h"
#include "proto/space/frame_grid.h"

namespace foreland::client {

struct ViewerStatistics {
  uint64_t bytes_down = 0, bytes_up = 0;
  uint32_t keyframes = 0;       // received and applied
  uint32_t late_keyframes = 0;  // arrived after the time they were to be shown from
  Duration last_lateness;       // of the newest keyframe; negative is early
  Duration worst_lateness;
  uint64_t nodes_added = 0, nodes_removed = 0;
  uint64_t frames = 0;                       // with something to draw
  uint32_t resumed = 0, started_afresh = 0;  // new connections, by what their first keyframe started from
  Duration longest_resume;                   // from a new connection to its first keyframe
  uint64_t frames_outside = 0;  // of those: drawn from where one of the two keyframes does not promise its tolerance
};

// What to draw in one frame.
struct FrameView {
  const KeyframeMesh* mesh = nullptr;  // nullptr until the first keyframe is here; valid until the next call of frame()
  float weight = 0;                    // 0 shows mesh->from, 1 shows mesh->to
  proto::Pose pose;                    // the camera: M(t), or M(t_d) with strategy `delay`
  Time scene_time;                     // the time whose geometry is shown: t with `predict`, t_d otherwise
  uint32_t mesh_version = 0;           // changes when `mesh` does: upload buffers again
};

class Viewer {
 public:
  Viewer(const proto::ViewRequest& request, Duration pose_interval = Duration::milliseconds(50));

  // Takes one message from the server. An Error ends the session: show it and disconnect; the state stays as it was.
  Status receive(ByteSpan message, Time now);
  // The connection was lost, and there is a new one, to this server or another: greets again, and goes on from the
  // section held if the scene is the same. What was not sent yet is dropped.
  void reconnect(Time now);
  // Next message for the server, oldest first; false when there is none.
  bool takeOutgoing(Bytes& message);

  // The camera is at `pose` now. Queues pose updates as they are due. Call once per shown frame with non-decreasing
  // times.
  FrameView frame(Time now, const proto::Pose& pose);

  // Changes strategy, predictor, tolerance, lens in flight.
  void setRequest(const proto::ViewRequest& request);
  const proto::ViewRequest& request() const { return request_; }
  // How what comes is blended, from the next keyframe on; what is on its way goes on from where it is.
  void setBlend(Blend blend) { blend_ = blend; }
  Blend blend() const { return blend_; }
  // Announces a planned path (predictor kKnownPath) on the client's clock.
  void announcePath(const proto::Path& path);
  void requestTour(const std::string& name, double seconds);
  void requestGround(std::vector<glm::dvec2> lattice_points);
  // Replies, once each.
  std::optional<proto::TourReply> takeTour();
  std::optional<proto::GroundReply> takeGround();

  const std::optional<proto::Welcome>& welcome() const { return welcome_; }  // the last one
  bool isGreeted() const { return is_greeted_; }                             // on this connection
  // Valid after the welcome.
  const proto::FrameGrid& frameGrid() const { return replica_->frameGrid(); }
  // Ground height (m above the zero surface) of the newest section at a lattice place; nothing before the first
  // keyframe.
  std::optional<double> groundHeight(double x, double y) const;
  const ViewerStatistics& statistics() const { return statistics_; }
  // The sections held; nothing before the welcome. For tools and tests.
  const std::optional<Replica>& replica() const { return replica_; }

 private:
  Status onWelcome(proto::Welcome welcome);
  Status onKeyframe(const proto::KeyframeMessage& message, Time now);
  void send(Bytes message);
  void sendPose(Time now, const proto::Pose& pose);
  void countFrame(const FrameView& view);

  proto::ViewRequest request_;
  Duration pose_interval_;
  Blend blend_ = Blend::kKeyframe;
  std::optional<proto::Welcome> welcome_;
  bool is_greeted_ = false;             // on this connection
  std::optional<Time> reconnected_at_;  // and no keyframe has come since
  std::optional<proto::Path> path_;     // announced
  std::optional<Replica> replica_;
  Timeline timeline_;
  proto::PoseMemory poses_sent_;
  proto::KeyframeMemory keyframes_taken_;
  std::deque<Bytes> outgoing_;
  std::vector<proto::TimedPose> poses_;  // recent own poses, for M(t_d)
  std::optional<Time> last_pose_sent_;
  uint32_t received_keyframe_ = 0;
  Time received_at_;
  std::optional<proto::TourReply> tour_;
  std::optional<proto::GroundReply> ground_;
  uint32_t next_request_id_ = 1;
  ViewerStatistics statistics_;
};

}  // namespace foreland::client
