// Opens elevation files of any kind as one ElevationSource: what GDAL reads, and OpenEXR height maps. Everything that
// had to be assumed about an input is a sentence in its notes; everything that cannot be meant is an Error that names
// the file and the way out. GDAL's own messages never reach the terminal. Any thread may open; the source belongs to
// one thread at a time.
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "base/result.h"
#include "terrain/elevation_source.h"

namespace foreland::terrain {

enum class FrameChoice : uint8_t {
  kAuto,        // as the file's reference system says
  kPlanar,      // geographic input is flattened at its middle latitude (small areas only)
  kGeographic,  // coordinates without a reference system are degrees on WGS84
};

enum class HeightEncoding : uint8_t {
  kPlain,      // one band of heights
  kTerrarium,  // three bands of 8 bits: red * 256 + green + blue / 256 - 32768 metres
};

struct OpenOptions {
  std::optional<double> nodata{};        // replaces the file's own
  std::optional<double> spacing_m{};     // for inputs without a reference system (EXR, images)
  std::optional<std::string> channel{};  // EXR channel, band number, or variable of a file with several
  FrameChoice frame = FrameChoice::kAuto;
  HeightEncoding encoding = HeightEncoding::kPlain;
};

// Several inputs make a mosaic on the lattice of the first one; where they overlap, the first that has data counts.
Result<std::unique_ptr<ElevationSource>> openElevation(const std::vector<std::filesystem::path>& inputs,
                                                       const OpenOptions& options);

}  // namespace foreland::terrain
