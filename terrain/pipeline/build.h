// Elevation data in, one scene file out: read in windows, fill voids, quantise, bound, write. The file appears whole or
// not at all (terrain/store/scene_writer.h). Memory: four bytes a sample, and what the source, the filling of voids
// or the relief (5/4 bytes a sample) need; with epochs, another 12 bytes a sample (24 with a Catmull-Rom blend) and 9 a
// node. One caller; uses threads of its own while it runs.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <string>
#include <string_view>
#include <vector>

#include "base/result.h"
#include "terrain/elevation_source.h"
#include "terrain/epochs/epoch_layers.h"
#include "terrain/imagery/imagery.h"
#include "terrain/objects/placed_objects.h"
#include "terrain/picture_source.h"
#include "terrain/store/format.h"
#include "terrain/store/scene.h"

namespace foreland::terrain {

// What a scene has beside its ground, and how its pages stand in the file.
struct SceneAdditions {
  PageCoding page_coding = PageCoding::kPlain;
  std::vector<ObjectRequest> objects{};          // to place on the terrain
  PictureSource* picture = nullptr;              // imagery, on the source's lattice; null for none
  int imagery_quality = kDefaultImageryQuality;  // of WebP, 1 to 100
  std::string attribution{};                     // to be shown where the imagery is
};

struct BuildOptions {
  std::filesystem::path output;
  double height_quantum_m = 0.1;  // heights become whole quanta: each moves by at most half of one
  unsigned threads = 0;           // 0: one per processor
  // Whether to take the first of 1, 1/2 and 1/4 m instead that is larger than height_quantum_m and of which every
  // height of the source is a multiple, if there is one: no sample moves, and the scene costs fewer bits to send.
  // Filled voids are rounded.
  bool widen_quantum = false;
  // The ground at other times, for scenes that change; the first is laid over the source. In the order of their dates.
  std::vector<EpochRequest> epochs{};
  proto::EpochBlend epoch_blend = proto::EpochBlend::kLinear;
  SceneAdditions additions{};
};

// Called on the caller's thread. `report` gets the name of a stage and the fraction of it that is done, at least 0 and
// 1 of each. Once `keepGoing` returns false the build stops, leaves no file behind and returns an error.
struct Progress {
  std::function<void(std::string_view stage, double fraction)> report = [](std::string_view, double) {};
  std::function<bool()> keepGoing = [] { return true; };
};

struct BuildReport {
  uint32_t width = 0, height = 0;
  uint64_t samples = 0;
  uint64_t voids_filled = 0;
  std::vector<std::string> notes;  // those of the source, how voids were filled, and whether the quantum was widened
  double height_quantum_m = 0;     // of the scene
  int levels = 0;
  uint64_t nodes = 0;  // refinement vertices; padding not counted
  uint64_t file_bytes = 0;
  uint64_t scene_id = 0;
  double lowest_m = 0, highest_m = 0;
  std::vector<EpochReport> epochs;
  ImageryReport imagery;                // without tiles if there is none
  std::vector<std::string> warnings{};  // what of the source is doubtful
};

[[nodiscard]] Result<BuildReport> buildScene(ElevationSource& source, const BuildOptions& options,
                                             const Progress& progress = {});

}  // namespace foreland::terrain
