// Writes heights as an elevation file that openElevation reads back, row by row. The file appears whole or not at all.
// One owner.
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
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
  // Nothing of the file is left if the writer goes before finish() succeeded.
  virtual ~ElevationWriter() = default;
  // The next rows, from the top (north), each `width` samples.
  virtual Status writeRows(uint32_t count, std::span<const float> rows) = 0;
  virtual Status finish() = 0;
};

Result<std::unique_ptr<ElevationWriter>> createElevationFile(const ElevationFile& file);

}  // namespace foreland::terrain
