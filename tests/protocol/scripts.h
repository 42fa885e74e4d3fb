// What the viewers of the golden flights do, and over which scenes.
#pragma once

#include <deque>
#include <glm/vec3.hpp>
#include <memory>
#include <string>
#include <vector>

#include "base/bytes.h"
#include "base/time.h"
#include "proto/space/pose.h"
#include "server/session/session.h"
#include "server/session/world.h"

namespace foreland::test {

struct Waypoint {
  Duration at;
  glm::dvec3 eye, ahead;
};

// What the viewer does once, beside its poses: it sends a message, or connects and greets with it, or loses the
// connection and what is on its way.
struct Cue {
  enum class What : uint8_t { kMessage, kConnect, kDisconnect };
  Duration at;
  Bytes message;
  What what = What::kMessage;
  size_t max_section_nodes = server::SessionOptions{}.max_section_nodes;  // of the server that it connects to
};

struct Script {
  std::string name;
  std::shared_ptr<const server::World> world;
  std::vector<Waypoint> route;
  std::deque<Cue> cues;
  Duration clock_offset;  // the viewer's clock minus the server's

  // Straight from waypoint to waypoint, turning on the way: arithmetic alone, so that the bytes are the same
  // everywhere.
  proto::Pose poseAt(Duration t) const;
};

std::vector<Script> goldenScripts();

}  // namespace foreland::test
