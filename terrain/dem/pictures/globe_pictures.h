// Pictures of any kind that GDAL reads as one GlobePicture: grey, palette, RGB and RGBA of 8 bits, in latitude and
// longitude, or of maps, which are brought there first. They stay in memory, four bytes a pixel.
#pragma once

#include <filesystem>
#include <memory>
#include <vector>

#include "base/result.h"
#include "terrain/dem/pictures/open_pictures.h"
#include "terrain/globe_picture.h"

namespace foreland::terrain {

// Where files overlap, the finest shows, and of equals the first. A file without georeference is laid over the whole
// body, with a note. Errors name the file: not a picture, of other than 8 bits, of too many bands, too large for
// memory.
Result<std::unique_ptr<GlobePicture>> openGlobePictures(const std::vector<std::filesystem::path>& files,
                                                        const std::vector<std::filesystem::path>& allowed_folders,
                                                        AlphaChoice alpha);

}  // namespace foreland::terrain
