// A base's lattice refined where layers need it: tiles of heights, each as deep as it must be. One owner, one thread at
// a time.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "terrain/dem/insets/layer_stack.h"

namespace foreland::terrain {

// By how much what is drawn at full resolution, or is bilinear between the lattice's heights, differs from a layer's
// samples at most, metres: at those around which its heights alone count. Nothing if there are none such.
struct LayerResidual {
  std::optional<double> largest_m;
  uint64_t samples = 0;  // that were compared
};

class RefinedTiles {
 public:
  // The lattice is halved `depth` times. A tile takes of these halvings the fewest with which neither residuals nor the
  // differences from what `depth` gives exceed `residual_m`.
  RefinedTiles(const LayerStack& stack, int depth, double residual_m, std::span<Overlap> overlaps);

  glm::uvec2 size() const { return last_ + 1u; }  // samples
  // Heights of one row of the refined lattice, from the south.
  void readRow(uint32_t y, std::span<float> out) const;
  const std::vector<LayerResidual>& residuals() const { return residuals_; }
  // Of tiles that layers reach, how many have so many halvings.
  const std::vector<uint64_t>& tilesOfDepth() const { return tiles_of_depth_; }

 private:
  struct Tile {
    int depth = 0;
    std::vector<float> metres;
  };

  RefinedWindow windowOf(glm::uvec2 tile) const;
  bool isReached(const RefinedWindow& window) const;
  Tile makeTile(const RefinedWindow& window, std::span<Overlap> overlaps);
  double heightAt(glm::uvec2 at) const;
  double heightIn(const Tile& tile, const RefinedWindow& window, glm::uvec2 at) const;

  const LayerStack& stack_;
  int depth_;
  double residual_m_;
  uint32_t side_;            // of a tile, in cells of the refined lattice
  glm::uvec2 last_, tiles_;  // the last position; how many tiles
  std::vector<std::optional<Tile>> tile_;
  std::vector<LayerResidual> residuals_;
  std::vector<uint64_t> tiles_of_depth_;
};

}  // namespace foreland::terrain
