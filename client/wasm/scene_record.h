// The welcome of a server and places in its scene, as records. One thread.
#pragma once

#include <vector>

#include "client/screen.h"
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

MapPositionRecord mapPositionRecordOf(const ScreenPlace& place);

// How slopes along the lattice's axes become a normal.
SlopeFrameRecord slopeFrameOf(const proto::Frame& frame);

// Its attribution is that of the layer.
LayerRecord recordOf(const proto::TileLayer& layer);

}  // namespace foreland::client
