// A picture as GeoTIFF, on the lattice of an elevation, row by row. One owner.
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <span>

#include "base/result.h"
#include "terrain/dem/pictures/open_pictures.h"

namespace foreland::terrain {

class PictureWriter {
 public:
  // Removes what was written, unless finish() has succeeded.
  virtual ~PictureWriter() = default;
  // The next rows, from the top (north), sRGB.
  virtual Status writeRows(uint32_t count, std::span<const std::array<uint8_t, 3>> rows) = 0;
  virtual Status finish() = 0;
};

// Over the samples, with so many texels to each along either side. Its name must end in .tif or .tiff. JPEG inside, of
// quality 95.
Result<std::unique_ptr<PictureWriter>> createPicture(const std::filesystem::path& path, const PictureLattice& lattice,
                                                     uint32_t texels_a_sample);

}  // namespace foreland::terrain
