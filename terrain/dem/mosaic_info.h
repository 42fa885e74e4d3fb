// What a mosaic says of itself as an elevation source. One thread.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "base/result.h"
#include "terrain/dem/datum.h"
#include "terrain/dem/mosaic/mosaic.h"
#include "terrain/dem/mosaic/placement.h"
#include "terrain/elevation_source.h"

namespace foreland::terrain {

// The names of the files, for people.
std::string titleOf(const Mosaic& mosaic);

// Whether a source lists what it is put together from.
enum class InputList : uint8_t { kWhereDatumIsStated, kAlways };

// `notes` are those of opening the files. An Error: what was named as a geoid is none.
Result<ElevationInfo> describeMosaic(const Mosaic& mosaic, const RasterPlacement& placement,
                                     const std::optional<Datum>& datum, InputList list, std::vector<std::string> notes);

}  // namespace foreland::terrain
