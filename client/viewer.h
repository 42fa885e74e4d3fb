// The client's side of a session: bytes and times in, bytes and meshes out. It has no socket, clock or thread; the
// headless player (client/fly), the page (client/wasm) and the virtual world of tests and experiments (sim) are
// its hosts. One owner. Times are the client's clock: microseconds since an epoch that the host chooses once.
#pragma once

#include <array>
#include <deque>
#include <memory>
#include <optional>
#include <vector>

#include "client/drawn_mesh.h"
#include "client/imagery/tile_store.h"
#include "client/mesh/patch/keyframe_mesh.h"
#include "client/mesh/weights/blend.h"
#include "client/replica.h"
#include "client/shown_frame.h"
#include "client/timeline.h"
#include "proto/message/message.h"
#include "proto/space/frame_grid.h"

namespace foreland::client {

struct ViewerStatistics {
  uint64_t bytes_down = 0, bytes_up = 0;
  uint32_t keyframes = 0;       // received and applied
  uint32_t late_keyframes = 0;  // arrived after the time from which they were to be shown
  Duration last_lateness;       // of the newest keyframe; negative is early
  Duration worst_lateness;
  uint64_t nodes_added = 0, nodes_removed = 0;
  uint64_t tiles = 0, tile_bytes = 0;                   // received, on all connections; bytes as they are coded
  std::array<float, proto::kMaxTileLayers> texel_px{};  // the last statement, by layer; 0: none
  uint64_t frames = 0;                                  // frames with something to draw
  uint64_t frames_outside = 0;  // of these, frames whose camera is outside the region that a shown keyframe is computed
                                // for, so their error is not guaranteed
  uint32_t resumed = 0;         // reconnections whose first keyframe starts from the sections held
  uint32_t started_afresh = 0;  // reconnections whose first keyframe starts from nothing
  Duration longest_resume;      // from a reconnection to its first keyframe
};

// What to draw in one frame.
struct FrameView {
  // nullptr until the first keyframe; valid until the next call of frame() or receive()
  const KeyframeMesh* mesh = nullptr;
  float weight = 0;           // 0 shows mesh->from, 1 shows mesh->to
  proto::Pose pose;           // the camera: M(t), or M(t_d) with strategy `delay`
  Time shown_time;            // the time whose geometry is shown: t with `predict`, t_d otherwise
  uint32_t mesh_version = 0;  // changes when `mesh` does: upload buffers again
  // The largest error on the screen, in pixels, that the server guarantees for what is shown: infinity if the camera is
  // outside the region that a shown keyframe is computed for, as it is between a jump and the first keyframe after it.
  // With `current` it is that for the camera at `shown_time`: of the present one the server had not been told.
  float tolerance_px = 0;
};

class Viewer {
 public:
  explicit Viewer(const proto::ViewRequest& request, Blend blend = Blend::kKeyframe,
                  Duration pose_interval = Duration::milliseconds(50));

  // Handles one message from the server. An Error ends the session: show it and disconnect. What is drawn stays.
  Status receive(ByteSpan message, Time now);
  // Starts a session over a new connection, to the same server or another, after the old one was lost. Resumes from the
  // sections held if the scene is the same. Messages that were not sent yet are dropped.
  void reconnect(Time now);
  // Moves the next message for the server, oldest first, into `message`; false if there is none.
  bool takeOutgoing(Bytes& message);

  // What to draw with the camera at `pose`. Queues a pose update every pose interval. To be called once per frame, with
  // times that do not decrease.
  FrameView frame(Time now, const proto::Pose& pose);

  // The camera of the next frame will not have moved there, but jumped: to a landmark, to where a tour begins, or just
  // elsewhere about. The server is told, and begins anew there. Large jumps are recognised without.
  void jump();

  // Changes strategy, predictor, tolerance or lens during the session. The order is the blend's.
  void setRequest(const proto::ViewRequest& request);
  const proto::ViewRequest& request() const { return request_; }
  // Changes the blend, from the next keyframe on. Nodes in transition continue from the weights that they have.
  // Tells the server if its order is another. Keyframes do not adapt while it is above 1.
  void setBlend(Blend blend);
  Blend blend() const { return blend_; }
  // Announces a planned path, on the client's clock, for the predictor kKnownPath.
  void announcePath(const proto::Path& path);
  // Sets how scene time goes in scenes with epochs, whose last keyframes' scene time is in FrameView::mesh; on this
  // connection and later ones.
  void setSceneClock(const proto::SceneClock& clock);
  const std::optional<proto::SceneClock>& sceneClock() const { return scene_clock_; }
  void requestTour(const std::string& name, double seconds);
  // Gives the number that the reply will have.
  uint32_t requestGround(std::vector<glm::dvec2> lattice_points);
  // The same, of what is seen (proto/message/sight_message.h); the request's own number is not looked at. A viewshed
  // takes the place of one that is not told whole. Requests end with their connection.
  uint32_t requestSight(proto::SightRequest request);
  uint32_t requestViewshed(proto::ViewshedRequest request);
  void cancelRequest(uint32_t id);
  // The reply to such a request, once; nullopt until it arrives. Of a viewshed the next part.
  std::optional<proto::TourReply> takeTour();
  std::optional<proto::GroundReply> takeGround();
  // That to one request, where several parts of a host ask.
  std::optional<proto::GroundReply> takeGround(uint32_t id);
  std::optional<proto::SightReply> takeSight();
  std::optional<proto::ViewshedReply> takeViewshed();

  // The last welcome, of this connection or an earlier one.
  const std::optional<proto::Welcome>& welcome() const { return welcome_; }
  // Whether the welcome of this connection has arrived.
  bool isGreeted() const { return is_greeted_; }
  // To be called after the first welcome only.
  const proto::FrameGrid& frameGrid() const { return replica_->frameGrid(); }
  // The area of a large scene that the camera of the last frame is in (client/area.h), for the address of the next
  // connection; nullopt of a small scene, and before the first welcome or frame.
  std::optional<uint32_t> area() const;
  // Height of the ground (m above the zero surface) at a lattice position, as Replica::heightAt.
  std::optional<double> groundHeight(double x, double y) const;
  const ViewerStatistics& statistics() const { return statistics_; }
  // The sections held; nullopt before the first welcome. For tools and tests.
  const std::optional<Replica>& replica() const { return replica_; }
  // The tiles of relief and imagery that are held.
  const TileStore& tiles() const { return tiles_; }
  // The mesh of the last frame() that had one, and what has changed in it.
  DrawnMesh& drawn() { return *drawn_; }
  // From now on drawn(), and the mesh of a FrameView, is the newest mesh instead of the one that is to be shown: for a
  // host that prepares meshes ahead and draws them by a Schedule of its own.
  void drawAhead() { draws_ahead_ = true; }
  // From now on meshes have no vertices and no triangles, which saves nearly half of a keyframe's time: for a host that
  // draws nothing.
  void leaveMeshesEmpty() { has_meshes_ = false; }
  // What is shown when.
  const Timeline& timeline() const { return timeline_; }

 private:
  Status onWelcome(proto::Welcome welcome);
  Status onTile(proto::TileMessage message);
  Status onKeyframe(const proto::KeyframeMessage& message, Time now);
  void send(Bytes message);
  proto::ViewRequest asked() const;
  proto::KeyframeInterval interval() const;  // after the welcome
  std::shared_ptr<const MeshPatch> makePatch();
  void addToDrawn(std::shared_ptr<const MeshPatch> patch);
  void sendPose(Time now, const proto::Pose& pose);
  void sendPoseIfDue(Time now, const proto::Pose& pose);

  proto::ViewRequest request_;
  Duration pose_interval_;
  Blend blend_;
  std::optional<proto::Welcome> welcome_;
  bool is_greeted_ = false;
  std::optional<Time> reconnected_at_;  // until the first keyframe after it
  std::optional<proto::Path> path_;     // as announced
  std::optional<proto::SceneClock> scene_clock_;
  std::optional<Replica> replica_;
  TileStore tiles_;
  Timeline timeline_;
  std::unique_ptr<DrawnMesh> drawn_ = std::make_unique<DrawnMesh>();
  bool draws_ahead_ = false, has_meshes_ = true;
  proto::PoseMemory poses_sent_;
  proto::KeyframeMemory keyframes_taken_;
  std::deque<Bytes> outgoing_;
  CameraPath camera_;  // for M(t_d)
  std::optional<Time> last_pose_sent_;
  bool has_jumped_ = false;  // since the last pose that was sent
  uint32_t received_keyframe_ = 0;
  Time received_at_;
  std::optional<proto::TourReply> tour_;
  std::deque<proto::GroundReply> grounds_;
  std::deque<proto::SightReply> sights_;
  std::deque<proto::ViewshedReply> viewsheds_;
  uint32_t next_request_id_ = 1;
  ViewerStatistics statistics_;
};

}  // namespace foreland::client
