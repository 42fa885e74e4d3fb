// A recorded flight given to a module of the wasm preset, under node. Blocks.
#pragma once

#include <filesystem>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "base/result.h"
#include "lab/wire/flight.h"

namespace foreland::lab {

// Runs a script of lab/ on the module and the flight's messages, and takes the JSON that it prints.
// kNotFound, with what to do, if the module is not built or there is no node; kMalformed if the script fails.
Result<nlohmann::json> runInWasm(const std::string& script, const std::filesystem::path& module,
                                 const proto::Welcome& welcome, const std::vector<RecordedKeyframe>& flight);

}  // namespace foreland::lab
