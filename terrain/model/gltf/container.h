// The two forms of a glTF 2.0 file: .glb, which holds JSON and one buffer, and .gltf, which is JSON alone. Pure; any
// thread.
#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "base/bytes.h"
#include "base/result.h"

namespace foreland::terrain {

struct GltfContainer {
  nlohmann::json json;             // an object
  ByteSpan buffer;                 // of a .glb; within the file's bytes
  std::vector<std::string> notes;  // on what is odd about it
};

// Error, without the file's name: neither form, a truncated file, broken JSON, another version than 2.
[[nodiscard]] Result<GltfContainer> parseGltfContainer(ByteSpan bytes);

}  // namespace foreland::terrain
