// Elevation rasters of other grids over and under a base, and what they make of the base's lattice, refined by halving.
// Pure but for the transformations that layers bring; one thread at a time.
//
// Where several have data the upper one shows, at its edges mixed with what is below it by its feather's weights. The
// base shows as it is drawn at full resolution, so that bisection has no error between its samples; layers show by
// cubic interpolation of their samples.
#pragma once

#include <cstdint>
#include <functional>
#include <glm/vec2.hpp>
#include <span>
#include <string>
#include <vector>

#include "terrain/dem/insets/samples.h"
#include "terrain/dem/mosaic/overlap.h"

namespace foreland::terrain {

// Positions on the base's lattice to columns and rows of samples, or back; NaN where there is no transformation.
using MovePlaces = std::function<void(std::span<glm::dvec2>)>;

struct Layer {
  std::string name;
  Samples samples;             // those over the base
  std::vector<float> weights;  // of its samples (feather.h)
  MovePlaces to_samples, to_lattice;
  glm::dvec2 low{0, 0}, high{0, 0};  // hold it on the base's lattice
};

struct LayerStack {
  Samples base;                     // on the lattice: rows from the south
  std::vector<float> base_weights;  // for what lies below it; empty where nothing does
  std::vector<Layer> layers;        // the lowest first
  size_t below = 0;                 // so many of them lie below the base
  Samples bottom;                   // on the base's lattice, what shows where nothing else has data; may be empty
};

// Positions of the refined lattice: those of the base's times 2^depth.
struct RefinedWindow {
  glm::uvec2 first{0, 0}, size{0, 0};
};

inline constexpr int16_t kBase = -1, kMixed = -2, kNobody = -3;

struct MergedWindow {
  std::vector<float> metres;
  std::vector<int16_t> owners;  // whose height it is alone: a layer's index, or one of the three above
};

// `overlaps` collects for each layer how its heights compare with those below it.
MergedWindow merge(const LayerStack& stack, int depth, const RefinedWindow& window, std::span<Overlap> overlaps);

// The base's lattice with the voids filled that no layer covers: what `bottom` is to be. `filled` says how many these
// were, `note` how.
struct FilledBase {
  Samples samples;
  uint64_t filled = 0;
  std::string note;
};
FilledBase fillBase(const LayerStack& stack);

}  // namespace foreland::terrain
