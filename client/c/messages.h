// What crosses between a terrain's two threads: the host's, which draws and asks, and the session's. Plain data.
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <variant>
#include <vector>

#include "client/c/mesh_update.h"
#include "client/mesh/weights/blend.h"
#include "client/viewer.h"

namespace foreland::client {

// From the host's thread.
namespace told {
struct Frame {
  Time now;
  proto::Pose pose;
  double ground_reach = 1;  // samples about the eye of which the ground is needed
  uint32_t taken = 0;       // the newest mesh that the host has
};
struct Jump {};
struct Request {
  proto::ViewRequest request;
};
struct SetBlend {
  Blend blend;
};
struct Clock {
  proto::SceneClock clock;
};
struct Path {
  proto::Path path;
};
struct Token {
  std::string token;
};
struct Seen {
  bool is_seen;
};
struct Reconnect {};
struct Redraw {
  uint32_t count;  // of redraws, with this one
};
struct Heights {
  uint64_t question;
  std::vector<glm::dvec2> positions;  // on the lattice
};
struct Sight {
  uint64_t question;
  proto::SightRequest request;
};
struct Viewshed {
  uint64_t question;
  proto::ViewshedRequest request;
};
struct Cancel {
  uint64_t question;
};
}  // namespace told
using ToSession =
    std::variant<told::Frame, told::Jump, told::Request, told::SetBlend, told::Clock, told::Path, told::Token,
                 told::Seen, told::Reconnect, told::Redraw, told::Heights, told::Sight, told::Viewshed, told::Cancel>;

// From the session's.
namespace from {
struct Welcome {
  proto::Welcome welcome;
};
struct Mesh {
  uint32_t redraws;  // that the session had been told of
  Interval interval;
  uint32_t oldest_version;
  std::unique_ptr<const MeshUpdate> update;  // null if the host wants no meshes
};
struct State {
  ViewerStatistics statistics;
  uint64_t tile_bytes = 0;  // of the tiles held
  bool is_connected = false;
  Bytes ground{};  // for Screen::takeGround
};
struct Stall {
  Duration wait;
  std::string reason;  // a sentence, or empty
};
struct Migrate {};
struct Refused {
  std::string reason;
};
struct Failed {
  std::string reason;
};
struct Heights {
  uint64_t question;
  std::vector<float> heights_m, undulations_m;
};
struct Sights {
  uint64_t question;
  proto::SightReply reply;
};
struct Viewshed {
  uint64_t question;
  proto::ViewshedReply reply;
};
struct Unanswered {
  uint64_t question;
  std::string reason;
};
}  // namespace from
using FromSession = std::variant<from::Welcome, from::Mesh, from::State, from::Stall, from::Migrate, from::Refused,
                                 from::Failed, from::Heights, from::Sights, from::Viewshed, from::Unanswered>;

}  // namespace foreland::client
