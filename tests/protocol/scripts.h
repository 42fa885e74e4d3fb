// What the viewers of the golden flights do, and over which scenes.
#pragma once

#include <glm/vec3.hpp>
#include <memory>
#include <string>
#include <vector>

#include "base/bytes.h"
#include "base/time.h"
#include "proto/pose.h"
#include "terrain/store/scene.h"

namespace foreland::test {

struct Waypoint {
  Duration at;
  glm::dvec3 eye, ahead;
};

// A message that the viewer sends once, beside its poses.
struct Cue {
  Duration at;
  Bytes message;
};

struct Script {
  std::string name;
  std::shared_ptr<const terrain::Scene> scene;
  std::vector<Waypoint> route;
  std::vector<Cue> cues;
  Duration clock_offset;  // the viewer's clock minus the server's

  // Straight from waypoint to waypoint, turning on the way: arithmetic alone, so that the bytes are the same
  // everywhere.
  proto::Pose poseAt(Duration t) const;
};

std::vector<Script> goldenScripts();

}  // namespace foreland::test
