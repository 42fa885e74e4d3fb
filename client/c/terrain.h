// A terrain of the C interface: the session's end in the host's thread. What is shown when and what is known of the
// ground is here; connection, decoding and meshes are in the session's thread. One owner.
#pragma once

#include <deque>
#include <limits>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "client/c/choice.h"
#include "client/c/foreland.h"
#include "client/c/session.h"
#include "client/screen.h"

namespace foreland::client {

// An event with what it points to.
struct Happening {
  ForelandEvent event{};
  std::string message{};
  std::vector<double> heights{}, undulations{};
  std::vector<ForelandSight> sights{};
  proto::ViewshedReply viewshed_reply{};
  ForelandViewshed viewshed{};
};

class Terrain {
 public:
  // `url` is one, and `choice` can be requested.
  Terrain(const std::string& url, WebSocketClient::Options connection, Choice choice);

  // Takes in what has come.
  void receive();
  // Until there is an event or an update that has not been taken, at most so long. Whether there is.
  bool wait(double milliseconds);
  // nullptr: nothing has happened. Valid until the next call.
  const ForelandEvent* nextEvent();

  bool hasScene() const { return screen_.welcome.has_value(); }
  // After the first scene event only, as all that asks where something is.
  const ForelandScene& scene() const { return scene_; }
  ForelandStats stats() const;

  // An Error leaves all as it is.
  Status setLens(const ForelandLens& lens);
  Status setOptions(const ForelandOptions& changes);
  Status setSceneClock(const proto::SceneClock& clock);
  Status announcePath(proto::Path path);
  void jump();
  void tell(ToSession message) { session_.tell(std::move(message)); }

  ForelandFrame frame(Time now, const proto::Pose& pose);
  // nullptr: there is none. Valid until the next call.
  const MeshUpdate* nextUpdate();
  void setReady(uint32_t ready, uint32_t coming) { ready_ = ready, coming_ = coming; }
  void redraw();

  const Screen& screen() const { return screen_; }
  glm::dvec3 pointOf(const ForelandMapPoint& place) const;
  glm::dvec2 latticeOf(const ForelandMapPoint& place) const;
  ForelandPlace placeOf(const glm::dvec3& point) const;
  uint64_t newQuestion() { return next_question_++; }
  // Answers that have come and not been taken are dropped, too.
  void cancel(uint64_t question);

 private:
  void on(from::Welcome message);
  void on(from::Mesh message);
  void on(from::State message);
  void on(from::Stall message);
  void on(from::Migrate message);
  void on(from::Refused message);
  void on(from::Failed message);
  void on(from::Heights message);
  void on(from::Sights message);
  void on(from::Viewshed message);
  void on(from::Unanswered message);

  void happen(uint32_t kind, double value = 0, std::string message = {});
  Happening& answer(uint32_t kind, uint64_t question);
  void tellScene();
  void tellGuarantee(double guaranteed_px);
  double groundReach(const glm::dvec3& eye);
  Status request(const Choice& choice);

  Choice choice_;
  proto::ViewRequest requested_;  // of choice_
  const bool has_meshes_;
  Screen screen_;
  std::deque<Happening> happenings_;
  Happening happening_;  // the one that was taken
  std::deque<std::unique_ptr<const MeshUpdate>> updates_;
  std::unique_ptr<const MeshUpdate> update_;  // the one that was taken
  std::vector<FromSession> incoming_;         // scratch

  ForelandScene scene_{};
  std::vector<double> epochs_, landmarks_;
  from::State state_{};
  Time last_frame_{std::numeric_limits<int64_t>::min()};
  glm::dvec3 last_eye_{0};
  double guaranteed_px_ = std::numeric_limits<double>::infinity();
  uint32_t taken_ = 0;  // version of the newest mesh that the host has
  uint32_t ready_ = Schedule::kAllReady, coming_ = 0;
  uint32_t redraws_ = 0;
  uint64_t next_question_ = 1;

  Session session_;  // the last member: its thread ends first
};

}  // namespace foreland::client
