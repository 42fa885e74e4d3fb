// One elevation file as rows of heights, top row first as image formats have it, with what the file says about its
// place. The two readers (GDAL, OpenEXR) implement it; mosaic.h turns one or more of them into an ElevationSource.
// One owner, one thread at a time.
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
  Ellipsoid ellipsoid;   // geographic
  std::string crs_name;  // for people
  std::string crs_wkt;
};

// What a first look over the heights found; enough to tell sentinels and degrees.
struct HeightSurvey {
  uint64_t samples = 0;  // looked at
  uint64_t voids = 0;
  float lowest = 0, highest = 0;  // over what is not void
};

class Raster {
 public:
  virtual ~Raster() = default;
  virtual uint32_t width() const = 0;
  virtual uint32_t height() const = 0;
  virtual const std::string& name() const = 0;  // the file, as messages call it
  virtual const Georeference& georeference() const = 0;
  virtual const HeightSurvey& survey() const = 0;
  virtual const std::vector<std::string>& notes() const = 0;
  // Heights in metres, kVoid where there is none, of `count` rows from `first`, counted from the top. A row that cannot
  // be read is an error that names the file.
  virtual Status readRows(uint32_t first, uint32_t count, std::span<float> out) = 0;
};

}  // namespace foreland::terrain
