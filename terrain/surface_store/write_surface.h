// Writes a surface's file, whole or not at all (terrain/store/file/new_file.h). Any thread.
#pragma once

#include <filesystem>
#include <glm/vec3.hpp>
#include <span>
#include <vector>

#include "base/result.h"
#include "base/time.h"
#include "proto/section/surface_bounds.h"
#include "terrain/store/scene.h"
#include "terrain/surface/surface.h"
#include "terrain/surface_store/surface_format.h"

namespace foreland::terrain {

// The content of a file; the caller keeps it alive.
struct SurfaceContent {
  const TrueSurface& surface;
  std::vector<Time> pose_times{};                 // of its poses, ascending, if it has more than one
  std::span<const proto::SurfaceRecord> records;  // by slot (terrain/surface/bounds.h)
  proto::ErrorShape error_shape = proto::ErrorShape::kSpheroid;
  proto::AtlasLayout atlas{};       // without an image if there are no colours
  std::span<const Texel> texels{};  // atlas.width() * atlas.height(), row by row from the top, with filled gutters
  glm::dvec3 origin{0};             // where the model's file has the surface's (0, 0, 0)
  InnerSolids inner{};              // of the surface; none for one with a border or poses
  SceneOrigin about{};
};

// Returns the id of the content. Errors: the disk's, and more than 16 MiB of text. Content that contradicts itself is
// the caller's mistake and checked.
[[nodiscard]] Result<uint64_t> writeSurface(const std::filesystem::path& target, const SurfaceContent& content);

}  // namespace foreland::terrain
