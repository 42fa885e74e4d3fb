// Tiles of one grid that are laid on a lattice together, and where they are on it. One thread.
#pragma once

#include <algorithm>
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

inline constexpr double kAlike = 1.01;  // resolutions that differ by less are the same

// Over how much of a base's sample distance the edges of a group are mixed with what is below it, if nobody says: four
// samples, and at most an eighth of its shorter side. `sides` are in such samples.
inline double defaultFeather(glm::dvec2 sides) { return std::min(4.0, std::min(sides.x, sides.y) / 8.0); }

// Sorts groups of layers from the lowest to the uppermost by a key, of equals the first named on top.
template <class Group, class Key>
void sortUpwards(std::vector<Group>& groups, const Key& key) {
  std::ranges::reverse(groups);
  // By insertion, which is stable; libstdc++'s stable_sort uses what clang warns of.
  for (auto it = groups.begin(); it != groups.end(); ++it)
    std::rotate(std::ranges::upper_bound(groups.begin(), it, key(*it), {}, key), it, it + 1);
}

double medianOf(std::vector<double> values);

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
