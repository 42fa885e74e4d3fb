#include "lab/client/wasm_meshes.h"

#include <nlohmann/json.hpp>

#include "lab/programs/lab_folder.h"
#include "lab/wire/wasm_stream.h"

namespace foreland::lab {

std::filesystem::path wasmMesherPath() { return wasmModulePath("foreland-mesher"); }

Result<ClientCosts> measureInWasm(const std::filesystem::path& module, const proto::Welcome& welcome,
                                  const std::vector<RecordedKeyframe>& flight,
                                  const std::vector<KeyframeCosts>& keyframes) {
  const auto report = runInWasm("client/make_meshes.mjs", module, welcome, flight);
  if (!report) return report.error();
  std::vector<KeyframeCosts> all = keyframes;
  for (size_t i = 0; i < all.size(); ++i) {
    if (report->at("triangles").at(i) != all[i].triangles)
      return Error{ErrorCode::kMalformed, "keyframe " + std::to_string(i) + " has another mesh in WebAssembly"};
    all[i].decode_s = 1e-3 * report->at("decode_ms").at(i).get<double>();
    all[i].mesh_s = 1e-3 * report->at("mesh_ms").at(i).get<double>();
    all[i].full_mesh_s = 1e-3 * report->at("full_mesh_ms").at(i).get<double>();
  }
  return costsOf(all, report->at("memory_bytes"));
}

}  // namespace foreland::lab
