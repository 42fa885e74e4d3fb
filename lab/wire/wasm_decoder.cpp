#include "lab/wire/wasm_decoder.h"

#include <nlohmann/json.hpp>

#include "lab/programs/lab_folder.h"
#include "lab/wire/wasm_stream.h"

namespace foreland::lab {

std::filesystem::path wasmDecoderPath() { return wasmModulePath("foreland-decoder"); }

Result<WasmTimes> decodeInWasm(const std::filesystem::path& module, const proto::Welcome& welcome,
                               const std::vector<RecordedKeyframe>& flight) {
  const auto report = runInWasm("wire/decode_stream.mjs", module, welcome, flight);
  if (!report) return report.error();
  return WasmTimes{report->at("first_s"), report->at("rest_s"), report->at("digest"), report->at("node")};
}

}  // namespace foreland::lab
