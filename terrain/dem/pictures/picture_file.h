// One picture file as bands of red, green, blue and, if it has one, alpha, with a position on the lattice. One owner,
// one thread.
#pragma once

#include <filesystem>
#include <glm/vec2.hpp>
#include <memory>
#include <string>
#include <vector>

#include "base/result.h"
#include "terrain/dem/formats/gdal_dataset.h"
#include "terrain/dem/formats/gdal_files.h"
#include "terrain/dem/pictures/lattice_map.h"

namespace foreland::terrain {

struct PictureFile {
  std::shared_ptr<const GdalFence> fence;
  std::string name;
  GdalDataset file;                  // as it was opened
  std::vector<GdalDataset> sources;  // what `colours` is made of, if not of the file itself
  GdalDataset colours;               // of `file`: three bands of 8 bits, or four with alpha
  double resolution = 1;             // sample intervals that a pixel spans, where it lies on the scene
  glm::dvec2 low{0, 0}, high{0, 0};  // holds the picture on the lattice
  std::vector<std::string> notes;
};

// One file without a position on a lattice: the rest of it stays as it is.
Result<PictureFile> openColours(const std::filesystem::path& path, const std::shared_ptr<const GdalFence>& fence,
                                AlphaChoice alpha);

// One file, or more if it is in latitude and longitude and the scene lies on both sides of where its longitudes end:
// the same pixels again, a turn of the globe further.
Result<std::vector<PictureFile>> openPicture(const std::filesystem::path& path, const PictureLattice& lattice,
                                             const LatticeMap& map);

// A dataset in memory without bands, or with red, green, blue and alpha, whose upper left corner is at a lattice
// position.
GdalDataset latticeDataset(const LatticeMap& map, const glm::dvec2& upper_left, double texel, const glm::uvec2& size,
                           int bands);

}  // namespace foreland::terrain
