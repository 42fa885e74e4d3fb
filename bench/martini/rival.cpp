#include "bench/martini/rival.h"

#include <algorithm>
#include <bit>
#include <fstream>
#include <nlohmann/json.hpp>

#include "bench/programs/run_program.h"
#include "bench/programs/temporary_folder.h"

namespace foreland::bench {

namespace {

namespace fs = std::filesystem;

constexpr uint32_t kMaxGridSize = 4097;

// Metres, row by row from the south-west, as floats of this machine's order.
Status writeHeights(const terrain::Scene& scene, uint32_t size, const fs::path& path) {
  std::ofstream file(path, std::ios::binary);
  std::vector<float> row(size);
  for (uint32_t y = 0; y < size; ++y) {
    for (uint32_t x = 0; x < size; ++x)
      row[x] = static_cast<float>(scene.height(proto::NodeId::at(x, y)) * scene.frame().height_quantum_m);
    file.write(reinterpret_cast<const char*>(row.data()), static_cast<std::streamsize>(row.size() * sizeof(float)));
  }
  file.close();
  if (!file)
    return Error{ErrorCode::kIo,
                 path.string() + ": cannot be written; free some space, or set TMPDIR to where there is"};
  return {};
}

nlohmann::json toJson(const std::vector<MartiniRequest>& requests) {
  nlohmann::json list = nlohmann::json::array();
  for (const MartiniRequest& request : requests)
    list.push_back({{"triangles", request.triangles}, {"max_error_m", request.max_error_m}});
  return list;
}

Result<MartiniResult> parse(const std::string& text) {
  try {
    const nlohmann::json json = nlohmann::json::parse(text);
    MartiniResult result{.version = json.at("version"),
                         .node = json.at("node"),
                         .grid_size = json.at("grid_size"),
                         .tables_ms = json.at("tables_ms"),
                         .tile_ms = json.at("tile_ms"),
                         .clear_ms = json.at("clear_ms"),
                         .meshes = {}};
    for (const nlohmann::json& mesh : json.at("meshes"))
      result.meshes.push_back({.max_error_m = mesh.at("max_error_m"),
                               .true_error_m = mesh.at("true_error_m"),
                               .triangles = mesh.at("triangles"),
                               .ms = mesh.at("ms"),
                               .mtri_per_s = mesh.at("mtri_per_s")});
    return result;
  } catch (const nlohmann::json::exception& e) {
    return Error{ErrorCode::kMalformed, std::string("martini.mjs printed what is no report: ") + e.what()};
  }
}

}  // namespace

uint32_t martiniGridSize(const proto::GridShape& shape) {
  const uint32_t intervals = std::min(shape.samples_x, shape.samples_y) - 1;
  return std::min(std::bit_floor(intervals) + 1, kMaxGridSize);
}

Result<MartiniResult> runMartini(const terrain::Scene& scene, const fs::path& folder,
                                 const std::vector<MartiniRequest>& requests) {
  std::error_code ignored;
  if (!fs::exists(folder / "node_modules/@mapbox/martini/package.json", ignored))
    return Error{ErrorCode::kNotFound, "@mapbox/martini is not installed; run: npm ci --prefix " + folder.string()};
  const TemporaryFolder scratch;
  if (scratch.path().empty())
    return Error{ErrorCode::kIo, "no temporary folder can be made; set TMPDIR to where one can"};
  const uint32_t size = martiniGridSize(scene.grid().shape());
  const fs::path heights = scratch.path() / "heights.f32";
  if (Status s = writeHeights(scene, size, heights); !s.ok()) return s.error();
  // One thread, so that the processor time of the process is that of one core; it makes MARTINI no slower.
  const auto text = runProgram({"node", "--single-threaded", (folder / "martini.mjs").string(), heights.string(),
                                std::to_string(size), toJson(requests).dump()});
  if (!text && text.error().code == ErrorCode::kNotFound)
    return Error{ErrorCode::kNotFound,
                 "node is not installed; install nodejs, then run: npm ci --prefix " + folder.string()};
  if (!text) return text.error();
  return parse(*text);
}

}  // namespace foreland::bench
