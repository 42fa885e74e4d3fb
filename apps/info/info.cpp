// foreland-info: prints what a scene or surface file holds, for people or (--json) for programs. Exit codes: 0 done, 2
// if the file cannot be read as either.
#include <CLI/CLI.hpp>
#include <cinttypes>
#include <cstdio>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "apps/info/info_map.h"
#include "apps/info/info_objects.h"
#include "apps/info/info_surface.h"
#include "apps/info/info_tiles.h"
#include "apps/info/info_vertical.h"
#include "apps/options/command_line.h"
#include "apps/options/date.h"
#include "apps/options/options.h"
#include "terrain/store/scene.h"

namespace {

using namespace foreland;
using nlohmann::ordered_json;

constexpr double kDegrees = 57.29577951308232;

std::string hexadecimal(uint64_t id) {
  char text[17];
  std::snprintf(text, sizeof(text), "%016" PRIx64, id);
  return text;
}

uint64_t nodeCount(const terrain::Scene& scene) {
  const proto::GridTopology& grid = scene.grid();
  if (scene.isSparse()) {
    uint64_t nodes = 0;
    scene.pages().forEachPage([&](proto::Slot first, uint64_t) {
      for (proto::Slot slot = first; slot < first + proto::kPageSlots; ++slot)
        nodes += grid.node(slot) == proto::NodeId{} ? 0 : 1;
    });
    return nodes;
  }
  const proto::GridShape& s = grid.shape();
  if (grid.isCube()) return 6ull * grid.rootSize() * grid.rootSize() + 2 - 14;  // but for corners and centres of faces
  const uint64_t base = (s.roots_x + 1ull) * (s.roots_y + 1ull) + static_cast<uint64_t>(s.roots_x) * s.roots_y;
  return (grid.maxX() + 1ull) * (grid.maxY() + 1ull) - base;
}

// Of coded pages, with their tables.
double pageBits(const terrain::Scene& scene) {
  const proto::GridShape& s = scene.grid().shape();
  const double samples = scene.isSparse() || scene.grid().isCube() ? static_cast<double>(nodeCount(scene))
                                                                   : static_cast<double>(s.samples_x) * s.samples_y;
  return 8.0 * static_cast<double>(scene.coded()->codedBytes()) / samples;
}

ordered_json pair(const glm::dvec2& v) { return {v.x, v.y}; }

// Everything that is needed to convert a position in the scene frame to the map and back.
ordered_json describeFrame(const terrain::Scene& scene) {
  const proto::Frame& f = scene.frame();
  ordered_json frame;
  if (f.kind == proto::FrameKind::kPlanar) {
    frame["kind"] = "planar";
    frame["axes"] = {"map x", "map y", "up"};
    frame["origin"] = {{"map_m", pair(f.map_origin_m)}, {"lattice", pair(f.anchor)}};
    frame["axis_x_m"] = pair(f.axis_x_m);
    frame["axis_y_m"] = pair(f.axis_y_m);
  } else if (f.kind == proto::FrameKind::kGlobe) {
    frame["kind"] = "globe";
    frame["axes"] = {"to longitude 0 on the equator", "to longitude 90 on the equator", "to the north pole"};
    frame["face_steps"] = f.face_steps;
    frame["floor_m"] = f.floor();
    frame["ellipsoid"] = {{"semi_major_m", f.semi_major_m}, {"flattening", f.flattening}};
  } else {
    frame["kind"] = "geographic";
    frame["axes"] = {"east", "north", "up"};
    frame["origin"] = {{"latitude_deg", f.origin.latitude_rad * kDegrees},
                       {"longitude_deg", f.origin.longitude_rad * kDegrees},
                       {"height_m", f.origin.height_m}};
    frame["south_west"] = {{"latitude_deg", f.latitude0_rad * kDegrees},
                           {"longitude_deg", f.longitude0_rad * kDegrees}};
    frame["step"] = {{"latitude_deg", f.latitude_step_rad * kDegrees},
                     {"longitude_deg", f.longitude_step_rad * kDegrees}};
    frame["ellipsoid"] = {{"semi_major_m", f.semi_major_m}, {"flattening", f.flattening}};
  }
  frame["crs"] = scene.origin().crs_wkt;
  frame["height_quantum_m"] = f.height_quantum_m;
  return frame;
}

// What epoch i costs in the file, without what it shares with the one before.
double epochMegabytes(const terrain::EpochTable& table, uint32_t i) {
  return static_cast<double>(table.newBlocks(i) * sizeof(terrain::OffsetBlock)) * 1e-6;
}

ordered_json describeEpochs(const terrain::EpochTable& table) {
  ordered_json epochs = ordered_json::array();
  for (uint32_t i = 0; i < table.epochs().size(); ++i) {
    const proto::Epoch& epoch = table.epochs()[i];
    const proto::LatticeWindow& w = epoch.moved;
    epochs.push_back({{"date", apps::dateText(epoch.time)},
                      {"window", {w.x, w.y, w.width, w.height}},
                      {"megabytes", epochMegabytes(table, i)}});
  }
  return epochs;
}

void printEpochs(const terrain::EpochTable& table) {
  if (!table.epochs().empty())
    std::printf("blend      %s, from epoch to epoch\n", std::string(proto::name(table.epochs().blend())).c_str());
  for (uint32_t i = 0; i < table.epochs().size(); ++i) {
    const proto::Epoch& epoch = table.epochs()[i];
    const proto::LatticeWindow& w = epoch.moved;
    if (w.isEmpty())
      std::printf("epoch      %s\n", apps::dateText(epoch.time).c_str());
    else
      std::printf("epoch      %s: %u x %u samples from (%u, %u) differ from the first, %.3f MB\n",
                  apps::dateText(epoch.time).c_str(), w.width, w.height, w.x, w.y, epochMegabytes(table, i));
  }
}

ordered_json describe(const std::string& path, const terrain::Scene& scene) {
  const proto::GridShape& shape = scene.grid().shape();
  const double quantum_m = scene.frame().height_quantum_m;
  ordered_json about;
  about["file"] = path;
  about["title"] = scene.origin().title;
  about["id"] = hexadecimal(scene.id());
  about["samples"] = {shape.samples_x, shape.samples_y};
  about["roots"] = {shape.roots_x, shape.roots_y};
  about["root_samples"] = scene.grid().rootSize() + 1;
  about["levels"] = scene.grid().maxLevel();
  if (scene.isSparse()) about["sparse_levels"] = shape.sparse_levels;
  about["nodes"] = nodeCount(scene);
  about["lowest_m"] = scene.heightRange().lowest * quantum_m;
  about["highest_m"] = scene.heightRange().highest * quantum_m;
  about["vertical"] = apps::describeVertical(scene);
  about["frame"] = describeFrame(scene);
  about["voids_filled"] = scene.origin().voids_filled;
  about["notes"] = scene.origin().notes;
  if (scene.coded())
    about["pages"] = {{"coded", true}, {"bytes", scene.coded()->codedBytes()}, {"bits_a_sample", pageBits(scene)}};
  if (const proto::Epochs& epochs = scene.epochs().epochs(); !epochs.empty()) {
    about["epoch_blend"] = proto::name(epochs.blend());
    about["epochs"] = describeEpochs(scene.epochs());
  }
  about["tiles"] = apps::describeTiles(scene.tiles());
  return about;
}

void printFrame(const proto::Frame& f, const std::string& crs_wkt) {
  if (f.kind == proto::FrameKind::kPlanar) {
    std::printf("frame      planar, metres of the map\n");
    std::printf("  origin   map (%.3f, %.3f) m, at lattice (%.3f, %.3f)\n", f.map_origin_m.x, f.map_origin_m.y,
                f.anchor.x, f.anchor.y);
    std::printf("  axes     a sample along x is (%.6g, %.6g) m, along y (%.6g, %.6g) m\n", f.axis_x_m.x, f.axis_x_m.y,
                f.axis_y_m.x, f.axis_y_m.y);
  } else if (f.kind == proto::FrameKind::kGlobe) {
    std::printf("frame      globe, six faces of %u x %u cells, earth-centred axes\n", f.face_steps, f.face_steps);
    std::printf("  ellipsoid %.3f m, flattening 1 / %.9f; no ground lies below %.1f m\n", f.semi_major_m,
                1 / f.flattening, f.floor());
  } else {
    std::printf("frame      geographic, local east-north-up\n");
    std::printf("  origin   latitude %.8f, longitude %.8f degrees, height %.3f m\n", f.origin.latitude_rad * kDegrees,
                f.origin.longitude_rad * kDegrees, f.origin.height_m);
    std::printf("  lattice  from latitude %.8f, longitude %.8f degrees in steps of %.8f, %.8f\n",
                f.latitude0_rad * kDegrees, f.longitude0_rad * kDegrees, f.latitude_step_rad * kDegrees,
                f.longitude_step_rad * kDegrees);
    std::printf("  ellipsoid  semi-major axis %.3f m, flattening 1/%.9g\n", f.semi_major_m,
                f.flattening > 0 ? 1 / f.flattening : 0.0);
  }
  std::printf("  crs      %s\n", crs_wkt.empty() ? "none" : crs_wkt.c_str());
}

void print(const std::string& path, const terrain::Scene& scene) {
  const proto::GridShape& shape = scene.grid().shape();
  const double quantum_m = scene.frame().height_quantum_m;
  std::printf("scene      %s\n", path.c_str());
  std::printf("title      %s\n", scene.origin().title.c_str());
  std::printf("id         %s\n", hexadecimal(scene.id()).c_str());
  std::printf("samples    %u x %u\n", shape.samples_x, shape.samples_y);
  std::printf("roots      %u x %u squares of %u samples a side\n", shape.roots_x, shape.roots_y,
              scene.grid().rootSize() + 1);
  if (scene.isSparse())
    std::printf("hierarchy  %d levels, the last %u of them in places, %" PRIu64 " nodes\n", scene.grid().maxLevel(),
                shape.sparse_levels, nodeCount(scene));
  else
    std::printf("hierarchy  %d levels, %" PRIu64 " nodes\n", scene.grid().maxLevel(), nodeCount(scene));
  if (scene.coded())
    std::printf("pages      coded, %.1f MB, %.2f bits a sample\n",
                static_cast<double>(scene.coded()->codedBytes()) * 1e-6, pageBits(scene));
  std::printf("heights    %.3f to %.3f m, multiples of %g m\n", scene.heightRange().lowest * quantum_m,
              scene.heightRange().highest * quantum_m, quantum_m);
  apps::printVertical(scene);
  printFrame(scene.frame(), scene.origin().crs_wkt);
  std::printf("voids      %" PRIu64 " filled\n", scene.origin().voids_filled);
  for (const std::string& note : scene.origin().notes) std::printf("note       %s\n", note.c_str());
  printEpochs(scene.epochs());
  apps::printTiles(scene);
}

void printJson(const ordered_json& about) {
  std::printf("%s\n", about.dump(2, ' ', false, ordered_json::error_handler_t::replace).c_str());
}

int fail(const Error& error) {
  std::fprintf(stderr, "foreland info: %s\n", error.message.c_str());
  return 2;
}

int showSurface(const std::string& path, bool json) {
  const auto surface = terrain::MappedSurface::open(path);
  if (!surface.ok()) return fail(surface.error());
  if (json) {
    ordered_json about{{"file", path}, {"kind", "surface"}};
    about.update(apps::describeSurface(**surface));
    printJson(about);
  } else {
    apps::printSurface(path, **surface);
  }
  return 0;
}

// The picture's legend goes with what is printed.
int showTerrain(const std::string& path, bool json, const std::optional<std::filesystem::path>& map) {
  const auto scene = terrain::Scene::open(path);
  if (!scene.ok()) return fail(scene.error());
  std::vector<apps::Outline> outlines;
  if (map) {
    outlines = apps::outlinesOf(**scene);
    if (Status s = apps::writeMap(*scene, outlines, *map); !s.ok()) return fail(s.error());
  }
  const auto objects = terrain::readObjects(*scene);
  if (!objects.ok()) return fail({objects.error().code, path + ": " + objects.error().message});
  if (json) {
    ordered_json about = describe(path, **scene);
    about["objects"] = apps::describeObjects(*objects);
    if (map) about["map"] = apps::describeOutlines(outlines);
    printJson(about);
  } else {
    print(path, **scene);
    apps::printObjects(*objects);
    apps::printOutlines(outlines);
  }
  return 0;
}

}  // namespace

int main(int argc, char** argv) {
  std::string path;
  bool json = false;
  std::optional<std::filesystem::path> map;
  CLI::App app("Prints what a scene or surface file holds.", "foreland info");
  app.add_option("SCENE", path, "a file made by `foreland build` or `foreland remesh`")
      ->type_name(apps::file("SCENE.fls"))
      ->required();
  app.add_flag("--json", json, "print JSON");
  app.add_option(
         "--map", map,
         "write a picture of a scene, too: its ground from above, north up, with the outlines of what it was put "
         "together from and of the windows in which it changes; their colours and resolutions are printed")
      ->type_name(apps::file("FILE.png"));
  const auto exit_code = apps::parseCommandLine(
      app, argc, argv,
      {{"a scene's size, heights, frame and notes", "foreland info hills.fls"},
       {"a picture of it, with its inputs' outlines", "foreland info hills.fls --map hills.png"}});
  if (exit_code) return *exit_code;
  if (!terrain::isSurfaceFile(path)) return showTerrain(path, json, map);
  if (map) return fail({ErrorCode::kInvalidArgument, path + ": a surface; --map is for scenes"});
  return showSurface(path, json);
}
