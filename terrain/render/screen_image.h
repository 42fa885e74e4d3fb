// Pictures for people: eight bits a channel, sRGB. Pure; any thread.
#pragma once

#include "terrain/model/png.h"
#include "terrain/render/picture.h"

namespace foreland::terrain {

[[nodiscard]] Image colourImage(const Picture& picture);
// In false colours: from dark blue over green to yellow at `tau_px`, then red, white from four times that; grey where
// there is no error to tell of.
[[nodiscard]] Image errorImage(const Picture& picture, double tau_px);

}  // namespace foreland::terrain
