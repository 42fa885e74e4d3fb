// The two forms of a glTF 2.0 file: .glb, which holds JSON and one buffer, and .gltf, which is JSON alone. Pure; any
// thread.
#pragma once

#include <nlohmann/json.hpp>

#include "base/bytes.h"
#include "base/result.h"

namespace foreland::terrain {

struct GltfContainer {
  nlohmann::json json;  // an object
  ByteSpan buffer;      // of a .glb; within the file's bytes
};

// Error, without the file's name: neither form, a truncated file, broken JSON, another version than 2.
[[nodiscard]] Result<GltfContainer> parseGltfContainer(ByteSpan bytes);

}  // namespace foreland::terrain
