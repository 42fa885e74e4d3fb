// The welcome of a server and places in its scene, as records. One thread.
#pragma once

#include <vector>

#include "client/wasm/records.h"
#include "proto/message/message.h"
#include "proto/space/frame.h"

namespace foreland::client {

// A WelcomeRecord with what it points to; its texts are those of the welcome.
class SceneRecord {
 public:
  const WelcomeRecord* fill(const proto::Welcome& welcome, const proto::FrameTransform& transform);

 private:
  WelcomeRecord record_{};
  std::vector<double> landmarks_, epochs_ms_;
  std::vector<uint32_t> model_sides_;
};

// A point of the scene in the coordinates of the data's owner; the ground's height there is given.
MapPositionRecord mapPositionOf(const proto::FrameTransform& transform, const glm::dvec3& point, double ground_m);

// The point of the scene at a place in those coordinates (MapPositionRecord::across) and a height above the zero
// surface.
glm::dvec3 scenePointOf(const proto::FrameTransform& transform, glm::dvec2 across, double height_m);

// How slopes along the lattice's axes become a normal.
SlopeFrameRecord slopeFrameOf(const proto::Frame& frame);

// Its attribution is that of the layer.
LayerRecord recordOf(const proto::TileLayer& layer);

}  // namespace foreland::client
