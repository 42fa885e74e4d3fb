// The georeference of a GDAL dataset. Thread of the dataset.
#pragma once

#include <string>
#include <vector>

#include "base/result.h"
#include "terrain/dem/raster/raster.h"

typedef void* GDALDatasetH;  // as GDAL declares them
typedef void* OGRSpatialReferenceH;

namespace foreland::terrain {

// Adds what had to be assumed to `notes`. Error for reference systems that a scene cannot have (geocentric, rotated
// pole).
Result<Georeference> readGeoreference(GDALDatasetH dataset, const std::string& name, std::vector<std::string>& notes);

// A reference system as text, and its ellipsoid.
std::string wktOf(OGRSpatialReferenceH crs);
Ellipsoid ellipsoidOf(OGRSpatialReferenceH crs);

// Adds what a file's own reference system says of heights to the georeference of a view of it. Null says nothing.
void readHeightStatement(OGRSpatialReferenceH crs, Georeference& out);

// The same reference system, of two dimensions.
std::string withoutHeights(const std::string& wkt);

// Whether two reference systems are the same but for heights, however they are spelled. Two unknown ones count as the
// same.
bool isSameReferenceSystem(const Georeference& a, const Georeference& b);

}  // namespace foreland::terrain
