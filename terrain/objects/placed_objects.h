// The objects of a scene file: models, which are whole surface files (terrain/surface_store), and where they stand. A
// section of the scene file of its own; docs/SCENE_FORMAT.md describes every byte. Any thread.
#pragma once

#include <filesystem>
#include <functional>
#include <glm/vec2.hpp>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "base/bytes.h"
#include "base/result.h"
#include "proto/refine/surface/objects.h"
#include "proto/space/frame.h"
#include "terrain/store/scene.h"
#include "terrain/surface_store/mapped_surface.h"

namespace foreland::terrain {

// An object that is to stand on a terrain.
struct ObjectRequest {
  std::filesystem::path model;
  glm::dvec2 at{0};              // latitude and longitude in degrees; of planar frames the map's x and y in metres
  double height_m = 0;           // of its lowest point above the ground; at its own place, above its own height
  double heading_deg = 0;        // clockwise from north, of the model's y axis
  double scale = 1;              // metres to one of the model
  bool is_at_own_place = false;  // where the model's own coordinates are on the map and in height, instead of `at`
};

// MODEL.fls@A,B[,height[,heading[,scale]]], or MODEL.fls@here[,height[,heading[,scale]]]. An Error says what is wrong
// and shows the form.
[[nodiscard]] Result<ObjectRequest> parseObject(const std::string& text);

// The section's bytes, empty without requests. `groundAt` tells the ground's height above the zero surface (m) at a
// lattice position, and is empty outside the data. `epochs` are the scene's, whatever their windows. Errors name the
// object and the remedy.
[[nodiscard]] Result<Bytes> makeObjectSection(const std::vector<ObjectRequest>& requests, const proto::Frame& frame,
                                              const proto::Epochs& epochs,
                                              const std::function<std::optional<double>(double x, double y)>& groundAt);

// Whether sessions can stream a surface: its bounds are spheroids, its image is laid out as AtlasLayout::of does.
[[nodiscard]] Status checkModel(const MappedSurface& surface);
// What a session is told of a surface before any of its nodes, in a scene of these epochs. An Error if one of its poses
// is at none of them.
[[nodiscard]] Result<proto::ObjectModel> modelOf(const MappedSurface& surface, const proto::Epochs& epochs);

// How the ground of a scene carries what stands at a point of its frame: as it moves there, or at the data's border
// next to it, by whole quanta.
[[nodiscard]] proto::GroundRise riseAt(const Scene& scene, const glm::dvec3& position);

struct PlacedObjects {
  std::vector<std::shared_ptr<const MappedSurface>> models;
  proto::ObjectSet set;
};

// The objects of a scene; they keep it open. Error if the section is damaged.
[[nodiscard]] Result<PlacedObjects> readObjects(const std::shared_ptr<const Scene>& scene);

struct ObjectsReport {
  uint64_t objects = 0;
  std::vector<VerifyReport> models;  // in the scene's order
};

// Reads the objects of a scene file and checks each model with verifySurface. Error, naming the file, if the scene
// cannot be opened or its objects cannot be read. Uses threads of its own while it runs.
[[nodiscard]] Result<ObjectsReport> verifyObjects(const std::filesystem::path& path, unsigned threads = 0);

}  // namespace foreland::terrain
