// Elevation on a map whose distances are those of the ground. One owner, one thread.
#pragma once

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

// The same heights, on such a map: a file that has control points alone is warped to their map, and one whose map is
// off by more than 0.5 % in the middle of the data (Mercator's) to latitude and longitude, unless `keeps_map`. What is
// not covered is void, as NaN. Error: control points that do not place it.
Result<TrueMap> onTrueMap(GdalDataset dataset, const std::string& name, bool keeps_map);

}  // namespace foreland::terrain
