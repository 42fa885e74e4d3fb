// Pictures of any kind that GDAL reads, warped to a scene's lattice as one PictureSource: grey, palette, RGB and RGBA
// of 8 bits, in any reference system. Memory is bounded, whatever the files' sizes. One owner, one thread at a time.
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "base/result.h"
#include "proto/space/frame.h"
#include "terrain/picture_source.h"

namespace foreland::terrain {

// What to make of a last band that is tagged as alpha. Some programs tag infrared so, whose water would be cut out.
enum class AlphaChoice : uint8_t {
  kAuto,  // alpha if hardly any of it is half transparent; else it is left out, with a note
  kUse,
  kIgnore,
};

// The lattice that pictures are laid on: a scene's, before it is built.
struct PictureLattice {
  proto::Frame frame;
  std::string crs_wkt;  // empty if none
  uint32_t samples_x = 0, samples_y = 0;
  std::vector<std::filesystem::path> allowed_folders{};  // beside its own, what a file may name files of
  AlphaChoice alpha = AlphaChoice::kAuto;
};

// A texel is the sample interval divided or multiplied by a power of two, and not coarser than the finest file's pixels
// (by more than 1 %), down to 1/1024 of the interval. Where files overlap, the finest shows, and of equals the first. A
// file without georeference is laid over all samples, with a note. Errors name the file: not a picture, of other than 8
// bits, of too many bands, beyond the scene.
Result<std::unique_ptr<PictureSource>> openPictures(const std::vector<std::filesystem::path>& files,
                                                    const PictureLattice& lattice);

}  // namespace foreland::terrain
