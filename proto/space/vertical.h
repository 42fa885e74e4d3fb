// What the heights of a scene count from, and how far the geoid lies above the ellipsoid over it: H above the sea, h
// above the ellipsoid, and the undulation N = h - H. Plain values, pure functions; any thread; portable to WebAssembly.
#pragma once

#include <cstdint>
#include <glm/vec2.hpp>
#include <optional>
#include <string>
#include <vector>

#include "base/result.h"

namespace foreland::proto {

enum class ZeroSurface : uint8_t { kUnstated = 0, kEllipsoid = 1, kGeoid = 2 };

// Undulations of a geoid over a scene, at lattice positions first + (column, row) * step, row by row from the south.
struct UndulationGrid {
  static constexpr uint32_t kMaxValues = 1u << 21;

  glm::dvec2 first{0, 0}, step{1, 1};
  uint32_t columns = 0, rows = 0;  // both 0, or both at least 2
  std::vector<float> metres;
  double max_error_m = 0;  // by which at() was seen to differ from the geoid, at most

  bool isEmpty() const { return metres.empty(); }
  // Bilinear; beyond the grid as at its border.
  double at(glm::dvec2 lattice) const;
  Status validate() const;
};

struct VerticalDatum {
  ZeroSurface zero_surface = ZeroSurface::kUnstated;
  std::string name;            // of the surface that heights count from; empty if it is not stated
  std::string geoid;           // whose undulations are known; empty if none are
  UndulationGrid undulations;  // of `geoid`

  Status validate() const;
};

// A height of the scene by both surfaces.
struct BothHeights {
  double above_sea_m, above_ellipsoid_m;
};
// Nothing where the datum is not stated, or the geoid's undulations are not known.
std::optional<BothHeights> bothHeights(const VerticalDatum& datum, glm::dvec2 lattice, double height_m);

// The same undulations at no more than `most` columns and rows; max_error_m covers what that loses.
UndulationGrid thinned(const UndulationGrid& grid, uint32_t most);

}  // namespace foreland::proto
