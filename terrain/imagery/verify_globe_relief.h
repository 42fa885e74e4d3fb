// The part of verify_tiles.h that is about relief on globes.
#pragma once

#include "terrain/imagery/verify_relief.h"

namespace foreland::terrain {

LayerReport verifyGlobeRelief(const Scene& scene, uint8_t layer, unsigned threads, Faults& faults);

}  // namespace foreland::terrain
