// Makes one seamless image of the texels of a surface's base faces: both faces of a base edge get the same texels along
// it, and the gutter around each face's triangle gets the colours of the neighbouring faces, so that a filter that
// reaches over an edge finds the right colours there (docs/SCENE_FORMAT.md has the rules).
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>

#include "proto/topology/atlas_layout.h"
#include "proto/topology/base_mesh.h"
#include "terrain/surface_store/surface_format.h"

namespace foreland::terrain {

// Keeps the texels inside the faces' triangles, makes those on base edges agree, and fills the gutters; pixels of no
// face become 0. Idempotent. The result does not depend on the number of threads.
void fillGutters(const proto::AtlasLayout& atlas, const proto::BaseMesh& mesh, std::span<Texel> texels,
                 unsigned threads);

// Describes the first fault of an image that fillGutters would change; empty if it would not. Copies the image
// meanwhile.
[[nodiscard]] std::optional<std::string> findSeam(const proto::AtlasLayout& atlas, const proto::BaseMesh& mesh,
                                                  std::span<const Texel> texels, unsigned threads);

}  // namespace foreland::terrain
