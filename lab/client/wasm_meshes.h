// The meshes of a recorded flight made in WebAssembly: by the code that the page runs, under node. Blocks.
#pragma once

#include <filesystem>

#include "lab/client/measure.h"

namespace foreland::lab {

// Where the wasm preset puts the module.
std::filesystem::path wasmMesherPath();

// The costs of the same keyframes; what does not depend on the machine is taken from `keyframes`. The memory is all of
// the module's. kNotFound, with what to do, if the module is not built or there is no node; kMalformed if a keyframe is
// refused or the meshes have other triangles.
Result<ClientCosts> measureInWasm(const std::filesystem::path& module, const proto::Welcome& welcome,
                                  const std::vector<RecordedKeyframe>& flight,
                                  const std::vector<KeyframeCosts>& keyframes);

}  // namespace foreland::lab
