// What a handle of the module stands for: a viewer, and the records that its exports fill. One owner, the page's
// worker.
#pragma once

#include <array>
#include <optional>
#include <string>
#include <vector>

#include "client/ground_supply.h"
#include "client/newest_mesh.h"
#include "client/viewer.h"
#include "client/wasm/records.h"
#include "client/wasm/scene_record.h"

namespace foreland::client {

struct Host {
  explicit Host(const proto::ViewRequest& request) : viewer(request) {}

  Viewer viewer;
  NewestMesh newest{viewer};
  Bytes outgoing;
  std::string error;
  proto::Path tour;
  SceneRecord welcome;
  std::vector<uint32_t> arrivals, dropped;

  FrameRecord frame_record{};
  // Of the terrain and the objects.
  std::array<ChangesRecord, 2> changes_records{};
  std::array<uint32_t, 2> taken_versions{};
  std::array<ChangedRanges, 2> changes;
  GroundSupply ground;
  StatisticsRecord statistics_record{};
  std::optional<proto::GroundReply> ground_reply;
  GroundRecord ground_record{};
  TextRecord text_record{};
  TilesRecord tiles_record{};
  ImageRecord image_record{};
};

}  // namespace foreland::client
