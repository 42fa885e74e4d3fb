// Brings inputs to one vertical datum before they are merged, and says what the result counts from. One thread.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "base/result.h"
#include "terrain/dem/mosaic/mosaic.h"
#include "terrain/dem/mosaic/placement.h"
#include "terrain/dem/raster/open_options.h"
#include "terrain/dem/vertical/height_reference.h"

namespace foreland::terrain {

// What heights count from once they are alike, and a geoid that is known over them.
struct Datum {
  HeightReference scene;
  HeightReference geoid;
};

// Nothing where neither the options nor a difference between the inputs makes heights a question: they stay as they
// are. Otherwise each tile's heights are those of one datum: the options' for the scene, else the first tile's that
// states one; a tile that states none has them already, which is noted. An Error, which names the file: a grid that is
// missing, a tile whose place on the earth is not known.
Result<std::optional<Datum>> alignHeights(std::vector<Tile>& tiles, const OpenOptions& options,
                                          std::vector<std::string>& notes);

// The datum with the geoid's undulations over the mosaic's lattice. What is not known is noted. An Error: what was
// named as a geoid is none.
Result<proto::VerticalDatum> datumOver(const Mosaic& mosaic, const RasterPlacement& placement, const Datum& datum,
                                       std::vector<std::string>& notes);

}  // namespace foreland::terrain
