// The comparison in `foreland bench wire`: what other makers' codecs take for the meshes that a client holds, in the
// same run. Every code is decoded and compared with its mesh before its bytes count. Keys: lab/README.md. Blocks.
#pragma once

#include <filesystem>
#include <nlohmann/json.hpp>
#include <vector>

#include "base/result.h"
#include "proto/space/view.h"
#include "server/section/hierarchy.h"

namespace foreland::lab {

struct PeerOptions {
  std::filesystem::path quantized_mesh;  // folder of decode.mjs and node_modules
  uint32_t samples = 8;                  // keyframes in flight, evenly spread
};

// Where decode.mjs lies.
std::filesystem::path peerSources();

// `views` are those of a flight's keyframes; the first is that of the first section. Without node or the npm package
// the figures of quantized-mesh are null, and `quantized_mesh_skipped` says why. An Error if a codec does not give back
// what it was given. Some seconds for a mesh of 100,000 vertices.
Result<nlohmann::ordered_json> peersReport(const server::Hierarchy& hierarchy, const std::vector<proto::View>& views,
                                           const PeerOptions& options);

}  // namespace foreland::lab
