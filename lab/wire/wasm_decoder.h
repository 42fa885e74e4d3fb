// A recorded flight decoded in WebAssembly: by the client that the page runs, under node. Blocks.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "base/result.h"
#include "lab/wire/flight.h"

namespace foreland::lab {

struct WasmTimes {
  double first_s = 0, rest_s = 0;  // processor time: the first keyframe, all others
  uint32_t digest = 0;             // of the last section (digest.h)
  std::string node;                // its version
};

// Where the `wasm` preset puts the module.
std::filesystem::path wasmDecoderPath();

// kNotFound, with what to do, if the module is not built or there is no node; kMalformed if a keyframe is refused.
Result<WasmTimes> decodeInWasm(const std::filesystem::path& module, const proto::Welcome& welcome,
                               const std::vector<RecordedKeyframe>& flight);

}  // namespace foreland::lab
