// An elevation file that is being written, row by row, in whichever format. One owner.
#pragma once

#include <cstdint>
#include <filesystem>
#include <span>

#include "base/result.h"

namespace foreland::terrain {

struct ElevationFile {
  std::filesystem::path path;  // .exr, .tif or .tiff
  uint32_t width = 0, height = 0;
  double spacing_m = 1;
};

class ElevationWriter {
 public:
  // Removes what was written, unless finish() has succeeded.
  virtual ~ElevationWriter() = default;
  // The next rows, from the top (north), each `width` samples.
  virtual Status writeRows(uint32_t count, std::span<const float> rows) = 0;
  virtual Status finish() = 0;
};

}  // namespace foreland::terrain
