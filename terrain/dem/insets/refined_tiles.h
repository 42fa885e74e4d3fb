// A base's lattice refined where layers need it: tiles of heights, each as deep as it must be. They are the leaves of
// quadtrees: 256 cells a side, of the lattice that is as fine as the finest layer over them, so that time and memory
// are in proportion to the layers' samples. One owner; what is const is for any thread.
#pragma once

#include <cstdint>
#include <functional>
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

// A height of the finest lattice, metres.
using LatticeHeightAt = std::function<double(glm::uvec2)>;

class RefinedTiles {
 public:
  struct Options {
    int depth = 0;            // so often the lattice is halved
    std::vector<int> depths;  // a layer takes at most so many of these halvings
    // A tile takes the fewest with which neither residuals nor the differences from what it may take exceed it.
    double residual_m = 0;
    // Whether to find out what isFineIn() tells, and to remember the samples that count for residualsAgainst(): 12
    // bytes each.
    bool is_sparse = false;
  };
  RefinedTiles(const LayerStack& stack, Options options, std::span<Overlap> overlaps);

  glm::uvec2 size() const { return last_ + 1u; }  // samples
  // At any position of the refined lattice; where tiles meet, that of the deepest.
  double heightAt(glm::uvec2 at) const;
  // Heights of one row of the refined lattice, from the south.
  void readRow(uint32_t y, std::span<float> out) const;
  // Whether heights that lie `spacing` apart, or closer, tell more than those twice as far apart in a block of 32 cells
  // of a tile that meets a window, which may reach beyond the lattice.
  bool isFineIn(uint32_t spacing, glm::uvec2 low, glm::uvec2 size) const;
  const std::vector<LayerResidual>& residuals() const { return residuals_; }
  // The same of another surface on the refined lattice, with the samples that were kept.
  std::vector<LayerResidual> residualsAgainst(const LatticeHeightAt& surface) const;

 private:
  // A sample of a layer, and where it is in its tile: from the first position of its window.
  struct Kept {
    float x, y, metres;
  };
  struct Tile {
    int own = 0;    // how often the lattice is halved that layers over it are as fine as, and its window is of
    int depth = 0;  // how often that of its heights is
    RefinedWindow window;
    std::vector<float> metres;
    std::vector<int8_t> block_depths{};        // of sparse lattices: how often that of a block's heights is
    std::vector<std::vector<Kept>> samples{};  // of sparse lattices, by layer
  };
  // One of a quadtree: four children from `children` on, or a tile, or neither.
  struct Branch {
    int32_t children = -1, tile = -1;
  };

  RefinedWindow windowOf(int level, glm::uvec2 index, int own) const;
  int levelFor(int level, const RefinedWindow& window) const;
  void grow(size_t branch, int level, glm::uvec2 index, std::span<Overlap> overlaps);
  Tile makeTile(int own, int least_depth, const RefinedWindow& window, std::span<Overlap> overlaps);
  struct Depths {
    int least, most;
  };
  std::vector<int8_t> blockDepths(const std::vector<float>& metres, const RefinedWindow& window, int own,
                                  Depths depths) const;
  // Calls visit(tile) for tiles that meet a window of the refined lattice, borders included.
  template <class Visit>
  void forEachIn(glm::uvec2 low, glm::uvec2 high, const Visit& visit) const;
  template <class Visit>
  void visitBranch(size_t branch, int level, glm::uvec2 index, glm::uvec2 low, glm::uvec2 high,
                   const Visit& visit) const;
  double heightIn(const Tile& tile, glm::uvec2 at) const;

  const LayerStack& stack_;
  Options options_;
  glm::uvec2 last_, roots_;  // the last position; how many quadtrees
  std::vector<Branch> branches_;
  std::vector<Tile> tiles_;
  std::vector<LayerResidual> residuals_;
};

}  // namespace foreland::terrain
