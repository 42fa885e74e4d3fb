// Elevation on a map whose distances are those of the ground. One owner, one thread.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "base/result.h"
#include "terrain/dem/formats/gdal_dataset.h"

namespace foreland::terrain {

struct TrueMap {
  std::vector<GdalDataset> sources;  // that the dataset is a view of, if any; to be closed after it
  GdalDataset dataset;
  std::vector<std::string> notes;
};

// What a file's map is for.
enum class MapUse : uint8_t {
  kGround,  // a scene's ground: distances on it must be true
  kKeep,    // the same, but the user wants this map; what is wrong with it is noted
  kPlace,   // it only says where samples are
};

// The same heights, on such a map: a file that has control points alone is warped to their map, and one whose map is
// off by more than 0.5 % in the middle of the data (Mercator's) to latitude and longitude, if it is to be a ground.
// What is not covered is void, as NaN. Error: control points that do not place it.
Result<TrueMap> onTrueMap(GdalDataset dataset, const std::string& name, MapUse use);

}  // namespace foreland::terrain
