// Elevation data as the builder sees it: a raster of heights on a lattice, and the frame of that lattice. Implemented
// by terrain/dem (files) and by tests (formulas). One owner; readRows may be called from one thread at a time.
#pragma once

#include <cstdint>
#include <limits>
#include <span>
#include <string>
#include <vector>

#include "base/result.h"
#include "proto/space/frame.h"

namespace foreland::terrain {

inline constexpr float kVoid = std::numeric_limits<float>::quiet_NaN();

struct ElevationInfo {
  uint32_t width = 0;              // samples along lattice x
  uint32_t height = 0;             // samples along lattice y
  proto::Frame frame;              // lattice (0, 0) is the south-west sample; the builder chooses its height quantum
  std::string title;               // file names, for people
  std::string crs_wkt;             // empty if none
  std::vector<std::string> notes;  // what was assumed about the input, a sentence each
};

class ElevationSource {
 public:
  virtual ~ElevationSource() = default;
  virtual const ElevationInfo& info() const = 0;
  // Heights in metres of `count` rows from lattice row `first` (0 is the southernmost), each `width` samples from the
  // west; kVoid where the source has no data. `out` holds count * width values.
  virtual Status readRows(uint32_t first, uint32_t count, std::span<float> out) = 0;
};

}  // namespace foreland::terrain
