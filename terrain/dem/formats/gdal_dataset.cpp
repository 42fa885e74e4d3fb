#include "terrain/dem/formats/gdal_dataset.h"

#include <cpl_string.h>
#include <gdal.h>
#include <ogr_srs_api.h>

#include "terrain/dem/formats/gdal_messages.h"

namespace foreland::terrain {

void CloseDataset::operator()(void* dataset) const {
  const GdalMessages silence;
  GDALClose(dataset);
}

void DestroyReferenceSystem::operator()(void* crs) const { OSRDestroySpatialReference(crs); }

void DestroyWords::operator()(char** words) const { CSLDestroy(words); }

std::unique_ptr<char*, DestroyWords> gdalWords(const std::vector<std::string>& words) {
  char** list = nullptr;
  for (const std::string& word : words) list = CSLAddString(list, word.c_str());
  return std::unique_ptr<char*, DestroyWords>(list);
}

}  // namespace foreland::terrain
