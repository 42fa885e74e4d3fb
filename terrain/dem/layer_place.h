// Tiles of one grid that are laid on a lattice together, and where they are on it. One thread.
#pragma once

#include <cmath>
#include <glm/vec2.hpp>
#include <optional>
#include <string>
#include <vector>

#include "base/result.h"
#include "terrain/dem/insets/layer_stack.h"
#include "terrain/dem/layered_source.h"
#include "terrain/dem/warp/sample_places.h"

namespace foreland::terrain {

struct TileGroup {
  std::optional<int> priority;  // of insets
  std::string name;             // of its files, as messages call them
  Mosaic mosaic;
};

// In the order of the first tile of each.
Result<std::vector<TileGroup>> groupTiles(std::vector<LaidTile> tiles);

struct LayerPlace {
  SamplePlaces places;
  glm::dvec2 low{0, 0}, high{0, 0};  // hold its samples on the lattice; infinite where that is not known
  bool meets_lattice = false;
  glm::dvec2 spacing{1, 1};  // lattice steps that its columns and rows are apart, in the middle of what lies on it

  // The root of the area, in lattice cells, that is a sample's: maps stretch one axis.
  double resolution() const { return std::sqrt(spacing.x * spacing.y); }
};

Result<LayerPlace> placeLayer(const TileGroup& group, const LatticePlace& lattice);

// The samples of a group that lie on the lattice or `margin` samples around it, with their places and without weights.
// Adds to `warnings` what tiles of the group disagree about.
Result<Layer> readLayer(TileGroup& group, const LayerPlace& place, const LatticePlace& lattice, uint32_t margin,
                        std::vector<std::string>& warnings);

}  // namespace foreland::terrain
