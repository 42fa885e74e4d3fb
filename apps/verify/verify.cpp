// foreland-verify: checks a scene with its objects, or a surface, and prints what it checked. Exit codes: 0 if the file
// is sound; 2 if it is damaged, or no scene or surface.
#include <CLI/CLI.hpp>
#include <cinttypes>
#include <cstdio>
#include <filesystem>
#include <string>
#include <vector>

#include "apps/globe_inputs.h"
#include "apps/options/command_line.h"
#include "apps/options/foreign_files.h"
#include "apps/options/options.h"
#include "apps/verify/verify_source.h"
#include "terrain/imagery/verify_tiles.h"
#include "terrain/objects/placed_objects.h"
#include "terrain/store/verify.h"
#include "terrain/surface_store/mapped_surface.h"

namespace {

using namespace foreland;

// What is checked of base vertices and of nodes, in words.
struct Checks {
  const char* base;
  const char* nodes;
};
constexpr Checks kTerrainChecks{
    "heights within the scene's range",
    "heights within range, errors cover the children's, spheres hold corners and the children's spheres"};
constexpr Checks kSurfaceChecks{"positions within the surface's box",
                                "positions within the box, spheres, cones and error shapes hold the children's"};

void printChecks(const Checks& checks, const terrain::VerifyReport& found) {
  std::printf("%" PRIu64 " blocks: contents against their checksums\n", found.blocks);
  std::printf("%" PRIu64 " base vertices: %s\n", found.base_vertices, checks.base);
  std::printf("%" PRIu64 " nodes: %s\n", found.nodes, checks.nodes);
  std::printf("%" PRIu64 " unused slots: zero\n", found.padding);
  if (found.texels > 0)
    std::printf("%" PRIu64 " texels: the same on both sides of base edges, gutters as neighbours have them\n",
                found.texels);
}

// Prints the first faults and returns how many there are.
uint64_t printFaults(const std::string& where, const terrain::VerifyReport& found) {
  for (const std::string& fault : found.first_faults)
    std::fprintf(stderr, "foreland verify: %s: %s\n", where.c_str(), fault.c_str());
  return found.faults;
}

int fail(const Error& error) {
  std::fprintf(stderr, "foreland verify: %s\n", error.message.c_str());
  return 2;
}

int conclude(const std::string& path, uint64_t faults) {
  if (faults == 0) {
    std::printf("%s: sound\n", path.c_str());
    return 0;
  }
  std::fprintf(stderr, "foreland verify: %s: %" PRIu64 " faults; build or copy the scene again\n", path.c_str(),
               faults);
  return 2;
}

int verifySurface(const std::string& path, unsigned threads) {
  const auto found = terrain::verifySurface(path, threads);
  if (!found.ok()) return fail(found.error());
  std::printf("header, sizes and table of checksums agree\n");
  printChecks(kSurfaceChecks, *found);
  return conclude(path, printFaults(path, *found));
}

// Prints what was checked of the tiles, and their faults; returns how many there are.
Result<uint64_t> verifyTiles(const std::string& path, unsigned threads) {
  constexpr double kDegrees = 57.29577951308232;
  const auto found = terrain::verifyTiles(path, threads);
  if (!found.ok()) return found.error();
  for (const terrain::LayerReport& layer : found->layers) {
    if (layer.content == proto::TileContent::kImagery) {
      std::printf("%" PRIu64 " tiles of imagery: decodable, bounds hold those of finer ones\n", layer.tiles);
      continue;
    }
    std::printf("%" PRIu64
                " tiles of relief: heights those of the samples, coarser ones their means, bounds hold them; normals "
                "%.3f degrees off (RMS), %.3f at most\n",
                layer.tiles, layer.rms_rad * kDegrees, layer.largest_rad * kDegrees);
  }
  for (const std::string& fault : found->first_faults)
    std::fprintf(stderr, "foreland verify: %s: %s\n", path.c_str(), fault.c_str());
  return found->faults;
}

struct Arguments {
  std::string path;
  unsigned threads = 0;
  std::vector<std::string> sources;
  apps::ForeignFiles foreign;
};

int verifyScene(const Arguments& arguments) {
  const std::string& path = arguments.path;
  const unsigned threads = arguments.threads;
  const auto found = terrain::verifyScene(path, threads);
  if (!found.ok()) return fail(found.error());
  std::printf("header, sizes and table of checksums agree\n");
  printChecks(kTerrainChecks, *found);
  uint64_t faults = printFaults(path, *found);
  const auto tiles = verifyTiles(path, threads);
  if (!tiles.ok()) return fail(tiles.error());
  faults += *tiles;
  const auto objects = terrain::verifyObjects(path, threads);
  if (!objects.ok()) return fail(objects.error());
  if (objects->objects > 0)
    std::printf("%" PRIu64 " objects: models exist, orientations are rotations, positions and scales within bounds\n",
                objects->objects);
  for (size_t i = 0; i < objects->models.size(); ++i) {
    const std::string name = "model " + std::to_string(i);
    std::printf("%s: header, sizes and table of checksums agree\n", name.c_str());
    printChecks(kSurfaceChecks, objects->models[i]);
    faults += printFaults(path + ": " + name, objects->models[i]);
  }
  const auto off = apps::verifySources(path, arguments.sources, arguments.foreign);
  if (!off.ok()) return fail(off.error());
  return conclude(path, faults + *off);
}

// All files that the command names.
std::vector<std::filesystem::path> filesOf(const Arguments& arguments) {
  std::vector<std::filesystem::path> files = apps::filesOfSources(arguments.sources);
  files.emplace_back(arguments.path);
  return files;
}

}  // namespace

int main(int argc, char** argv) {
  Arguments arguments;
  CLI::App app("Checks a scene or surface file's checksums and invariants.", "foreland verify");
  app.add_option("SCENE", arguments.path, "a file made by `foreland build` or `foreland remesh`")
      ->type_name(apps::file("SCENE.fls"))
      ->required();
  app.add_option("--source", arguments.sources,
                 "a file that the scene was made of, perhaps with @vertical=... as for `foreland build`: whether the "
                 "scene is within the residual that it states at the file's samples, as far as these alone count")
      ->type_name(apps::file("FILE"))
      ->allow_extra_args(false);
  apps::addForeignFiles(app, arguments.foreign);
  app.add_option("--threads", arguments.threads, "worker threads; 0 for one per processor")
      ->type_name(apps::whole("N"))
      ->check(apps::within(0u, 1024u))
      ->capture_default_str();
  if (const auto exit_code = apps::parseCommandLine(
          app, argc, argv,
          {{"whether a scene is sound", "foreland verify hills.fls"},
           {"and as close to a survey as it states", "foreland verify alps.fls --source survey.tif"}}))
    return *exit_code;
  if (!arguments.sources.empty()) apps::confineTo(arguments.foreign, filesOf(arguments), {});
  return terrain::isSurfaceFile(arguments.path) ? verifySurface(arguments.path, arguments.threads)
                                                : verifyScene(arguments);
}
