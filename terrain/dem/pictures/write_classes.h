// A raster of classes, a byte each, as GeoTIFF in a scene's reference system. Pure but for the file, which appears
// whole or not at all; one thread.
#pragma once

#include <cstdint>
#include <filesystem>
#include <glm/vec2.hpp>
#include <span>

#include "base/result.h"
#include "terrain/dem/pictures/open_pictures.h"

namespace foreland::terrain {

// Middles of cells at lattice positions first + (i, j) * step, rows from the south.
struct ClassGrid {
  glm::dvec2 first{0}, step{1};
  uint32_t columns = 0, rows = 0;
};

// `classes` row by row from the south. `no_data` is the class of cells of which nothing is known. The name must end in
// .tif or .tiff. An Error names the file and the remedy.
[[nodiscard]] Status writeClasses(const std::filesystem::path& path, const PictureLattice& lattice,
                                  const ClassGrid& grid, std::span<const uint8_t> classes, uint8_t no_data);

}  // namespace foreland::terrain
