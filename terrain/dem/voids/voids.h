// Fills the voids of a height grid from the data around them. Deterministic. Cost: linear in the number of samples;
// scratch of about a third of the grid's size. Data samples are never changed. Knows no file format, so any program may
// link it.
//
// Small regions get a membrane: a push-pull pyramid (Gortler et al., "The Lumigraph", 1996, section 3.4), each level of
// which is relaxed towards Laplace's equation, so the fill meets its rim without a step. Regions that are wide and
// large (sea, the missing half of a tile) become flat at a low height of their rim, a little way in; a membrane would
// invent hills there.
#pragma once

#include <cstdint>
#include <span>
#include <string>

namespace foreland::terrain {

struct VoidReport {
  uint64_t total = 0;           // samples of the grid
  uint64_t samples = 0;         // voids filled
  uint64_t regions = 0;         // connected regions of voids (4-neighbours); 0 if there were too many to tell apart
  uint64_t largest_region = 0;  // samples of the largest one
  uint64_t flat_regions = 0;    // of these, filled flat
  bool all_void = false;        // there was no data to fill from; heights are unchanged
  std::string note{};           // a sentence for people; empty if there were no voids
};

// `heights` holds height rows of width samples; a sample that is not finite is a void. Afterwards none is left, unless
// all_void.
VoidReport fillVoids(std::span<float> heights, uint32_t width, uint32_t height);

}  // namespace foreland::terrain
