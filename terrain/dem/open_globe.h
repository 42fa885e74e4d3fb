// Opens elevation files as the ground of a whole body: inputs that reach around it, and over them insets of any grid
// (decision 0061). Notes, errors and threads as of open.h.
#pragma once

#include <filesystem>
#include <memory>
#include <vector>

#include "base/result.h"
#include "terrain/dem/raster/open_options.h"
#include "terrain/globe_source.h"

namespace foreland::terrain {

// The first input, and those on its lattice, are the base: in latitude and longitude, around the body and to both
// poles, between whose samples heights are bilinear. Heights above a geoid become heights above the ellipsoid, by the
// geoid's undulations wherever they are asked for; what states nothing is taken as above the ellipsoid, with a note.
Result<std::unique_ptr<GlobeSource>> openGlobe(const std::vector<std::filesystem::path>& inputs,
                                               const OpenOptions& options);

}  // namespace foreland::terrain
