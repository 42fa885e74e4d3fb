#include "lab/martini/rival.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>
#include <optional>

#include "base/quantile.h"
#include "lab/martini/plain_martini.h"
#include "lab/programs/run_program.h"
#include "lab/programs/temporary_folder.h"
#include "lab/programs/write_file.h"
#include "sim/thread_time.h"

namespace foreland::lab {

namespace {

namespace fs = std::filesystem;

constexpr uint32_t kMaxGridSize = 4097;

// Metres, row by row from the south-west.
std::vector<float> heightsOf(const terrain::Scene& scene, uint32_t size) {
  std::vector<float> heights;
  heights.reserve(size_t{size} * size);
  for (uint32_t y = 0; y < size; ++y)
    for (uint32_t x = 0; x < size; ++x)
      heights.push_back(static_cast<float>(scene.height(proto::NodeId::at(x, y)) * scene.frame().height_quantum_m));
  return heights;
}

// As floats of this machine's order.
Status writeHeights(const std::vector<float>& heights, const fs::path& path) {
  return writeFile({reinterpret_cast<const uint8_t*>(heights.data()), heights.size() * sizeof(float)}, path);
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

template <class Work>
double milliseconds(const Work& work) {
  const double begin = sim::threadSeconds();
  work();
  return 1e3 * (sim::threadSeconds() - begin);
}

// As martini.mjs repeats: at least five times, then until a second and a half has gone.
template <class Work>
double medianMilliseconds(const Work& work) {
  constexpr size_t kFewest = 5, kMax = 41;
  std::vector<double> times;
  for (double total = 0; times.size() < kFewest || (times.size() < kMax && total < 1500); total += times.back())
    times.push_back(milliseconds(work));
  return median(times);
}

// By bisection, to half a percent or as near as the heights' quanta allow, with martini.mjs's arithmetic.
double errorForTriangles(PlainMartini& tile, double wanted) {
  double low = 0, high = tile.largestError_m(), best = high, distance = std::numeric_limits<double>::infinity();
  for (int i = 0; i < 30 && distance > 0.005 * wanted; ++i) {
    const double error = (low + high) / 2, count = static_cast<double>(tile.mesh(error).triangleCount());
    if (std::fabs(count - wanted) < distance) best = error, distance = std::fabs(count - wanted);
    (count > wanted ? low : high) = error;
  }
  return best;
}

MartiniMesh measure(PlainMartini& tile, const MartiniRequest& request) {
  const double error = request.triangles > 0 ? errorForTriangles(tile, request.triangles) : request.max_error_m;
  const double ms = medianMilliseconds([&] { tile.mesh(error); });
  const double triangles = static_cast<double>(tile.mesh(error).triangleCount());
  return {.max_error_m = error,
          .true_error_m = tile.trueError_m(),
          .triangles = triangles,
          .ms = ms,
          .mtri_per_s = triangles / (1000 * ms)};
}

}  // namespace

MartiniResult runPlainMartini(const terrain::Scene& scene, const std::vector<MartiniRequest>& requests) {
  MartiniResult result;
  result.grid_size = martiniGridSize(scene.grid().shape());
  std::vector<float> heights = heightsOf(scene, result.grid_size);
  std::optional<MartiniTables> tables;
  std::optional<PlainMartini> tile;
  result.tables_ms = milliseconds([&] { tables.emplace(result.grid_size); });
  result.tile_ms = milliseconds([&] { tile.emplace(*tables, std::move(heights)); });
  result.clear_ms = medianMilliseconds([&] { tile->clearIndices(); });
  for (const MartiniRequest& request : requests) result.meshes.push_back(measure(*tile, request));
  return result;
}

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
  if (Status s = writeHeights(heightsOf(scene, size), heights); !s.ok()) return s.error();
  // One thread, so that the processor time of the process is that of one core; it makes MARTINI no slower.
  const auto text = runProgram({"node", "--single-threaded", (folder / "martini.mjs").string(), heights.string(),
                                std::to_string(size), toJson(requests).dump()});
  if (!text && text.error().code == ErrorCode::kNotFound)
    return Error{ErrorCode::kNotFound,
                 "node is not installed; install nodejs, then run: npm ci --prefix " + folder.string()};
  if (!text) return text.error();
  return parse(*text);
}

}  // namespace foreland::lab
