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

#include "terrain/dem/voids/row_filler.h"

namespace foreland::terrain {

// `heights` holds height rows of width samples; a sample that is not finite is a void. Afterwards none is left, unless
// all_void.
VoidReport fillVoids(std::span<float> heights, uint32_t width, uint32_t height);

}  // namespace foreland::terrain
