#include "terrain/dem/open.h"

#include <utility>

#include "terrain/dem/layered_source.h"
#include "terrain/dem/mosaic/mosaic_source.h"
#include "terrain/dem/mosaic/placement.h"
#include "terrain/dem/mosaic_info.h"
#include "terrain/dem/opened_inputs.h"

namespace foreland::terrain {

Result<std::unique_ptr<ElevationSource>> openElevation(const std::vector<std::filesystem::path>& inputs,
                                                       const OpenOptions& options) {
  Result<OpenedInputs> opened = openInputs(inputs, options);
  if (!opened.ok()) return opened.error();
  if (!opened->others.empty())
    return layeredSource(std::move(opened->base), std::move(opened->others), options, opened->datum,
                         std::move(opened->notes));
  const Mosaic& mosaic = opened->base;
  const Result<RasterPlacement> placement =
      placeRaster(mosaic.map, {titleOf(mosaic), mosaic.width, mosaic.height, 0, 0}, options);
  if (!placement.ok()) return placement.error();
  Result<ElevationInfo> info =
      describeMosaic(mosaic, *placement, opened->datum, InputList::kWhereDatumIsStated, std::move(opened->notes));
  if (!info.ok()) return info.error();
  return mosaicSource(std::move(opened->base), *placement, std::move(*info));
}

}  // namespace foreland::terrain
