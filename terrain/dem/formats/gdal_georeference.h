// What a GDAL dataset says about its place, as a Georeference. Thread of the dataset.
#pragma once

#include <string>
#include <vector>

#include "base/result.h"
#include "terrain/dem/raster/raster.h"

typedef void* GDALDatasetH;  // as GDAL declares it

namespace foreland::terrain {

// Adds to `notes` what had to be assumed. Refuses systems that a scene cannot stand in (geocentric, rotated pole).
Result<Georeference> readGeoreference(GDALDatasetH dataset, const std::string& name, std::vector<std::string>& notes);

// The same reference system, whatever its spelling. Two unknown ones count as the same.
bool isSameReferenceSystem(const Georeference& a, const Georeference& b);

}  // namespace foreland::terrain
