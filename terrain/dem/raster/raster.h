// One elevation file as rows of heights, top row first as image formats have it, with what the file says about its
// position on a map. Both readers (terrain/dem/formats: GDAL, OpenEXR) implement it; openElevation turns one or more of
// them into an ElevationSource. One owner, one thread at a time.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "base/result.h"
#include "terrain/geo/geodesy.h"

namespace foreland::terrain {

enum class MapKind : uint8_t { kUnknown, kProjected, kGeographic };

struct Georeference {
  MapKind kind = MapKind::kUnknown;
  bool has_transform = false;
  // Map position of the centre of the sample at (column, row): x = t0 + column * t1 + row * t2, y = t3 + column * t4 +
  // row * t5.
  std::array<double, 6> transform{0, 1, 0, 0, 0, -1};
  double unit = 1;  // metres (projected) or radians (geographic) per unit of the map
  double prime_meridian_rad = 0;
  Ellipsoid ellipsoid;  // geographic
  // Metres per unit of the reference system's vertical part; nothing if it has none.
  std::optional<double> vertical_unit{};
  std::string vertical_unit_name{};
  // The reference system as the file has it, if that says what heights count from; `crs_wkt` may be of a view without.
  std::string heights_wkt;
  std::string crs_name;  // for people
  std::string crs_wkt;
};

// What a survey of the heights found: enough to recognise sentinels, and coordinates in degrees.
struct HeightSurvey {
  uint64_t samples = 0;  // that the survey read
  uint64_t voids = 0;
  float lowest = 0, highest = 0;  // metres, over the samples that are not void
};

struct RasterInfo {
  std::string name;  // the file, as messages call it
  uint32_t width = 0, height = 0;
  Georeference georeference{};
  HeightSurvey survey{};
  std::vector<std::string> notes{};  // what was assumed about the file, a sentence each
};

class Raster {
 public:
  virtual ~Raster() = default;
  virtual const RasterInfo& info() const = 0;
  // Heights in metres, kVoid where there is none, of `count` rows from `first`, counted from the top. A row that cannot
  // be read is an error that names the file.
  virtual Status readRows(uint32_t first, uint32_t count, std::span<float> out) = 0;
};

}  // namespace foreland::terrain
