// GDAL's datasets, reference systems and lists of words as owners, for C++. Threads as GDAL has it: one for each
// object.
#pragma once

#include <memory>
#include <string>
#include <vector>

namespace foreland::terrain {

struct CloseDataset {
  void operator()(void* dataset) const;
};
using GdalDataset = std::unique_ptr<void, CloseDataset>;

struct DestroyReferenceSystem {
  void operator()(void* crs) const;
};
using GdalReferenceSystem = std::unique_ptr<void, DestroyReferenceSystem>;

struct DestroyWords {
  void operator()(char** words) const;
};
// The words of a command line, as GDAL's utilities take them.
std::unique_ptr<char*, DestroyWords> gdalWords(const std::vector<std::string>& words);

}  // namespace foreland::terrain
