// The picture that `foreland synth` makes of an elevation.
#pragma once

#include <cstdint>
#include <filesystem>
#include <vector>

#include "base/result.h"

namespace foreland::apps {

struct PictureArguments {
  std::filesystem::path output;             // empty for none
  std::vector<std::filesystem::path> over;  // the elevation files
  uint32_t detail = 4;                      // texels between two samples
  uint32_t seed = 1;
};

// Prints what it made. Memory: four bytes a sample, and some rows of texels.
Status synthPicture(const PictureArguments& arguments);

}  // namespace foreland::apps
