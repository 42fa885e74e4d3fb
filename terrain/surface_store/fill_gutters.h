// What makes one image of a surface's base faces: both faces of a base edge hold the same texels along it, and beyond
// each face's triangle lies what the surface goes on with, so that a filter that reaches over an edge finds the right
// colours there (docs/SCENE_FORMAT.md has the rules).
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>

#include "proto/topology/atlas_layout.h"
#include "proto/topology/base_mesh.h"
#include "terrain/surface_store/surface_format.h"

namespace foreland::terrain {

// Takes the texels of the faces' triangles as given, makes those on base edges agree, and fills every pixel around
// them; pixels of no face become 0. Doing it again changes nothing. The result does not depend on the number of
// threads.
void fillGutters(const proto::AtlasLayout& atlas, const proto::BaseMesh& mesh, std::span<Texel> texels,
                 unsigned threads);

// What is wrong with an image that fillGutters would change; nothing if it would not. Takes a copy while it runs.
[[nodiscard]] std::optional<std::string> findSeam(const proto::AtlasLayout& atlas, const proto::BaseMesh& mesh,
                                                  std::span<const Texel> texels, unsigned threads);

}  // namespace foreland::terrain
