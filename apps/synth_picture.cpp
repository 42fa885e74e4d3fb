#include "apps/synth_picture.h"

#include <algorithm>
#include <cstdio>

#include "apps/options/output_file.h"
#include "terrain/dem/open.h"
#include "terrain/dem/pictures/write_picture.h"
#include "terrain/dem/voids/voids.h"
#include "terrain/geo/geodesy.h"
#include "terrain/parallel.h"
#include "terrain/synth/ground_colours.h"

namespace foreland::apps {

namespace {

using terrain::GroundColours;

constexpr uint32_t kPictureRows = 256;  // the height of a block of the file

Result<std::vector<float>> readGround(terrain::ElevationSource& source) {
  const terrain::ElevationInfo& info = source.info();
  std::vector<float> metres(size_t{info.width} * info.height);
  if (Status s = source.readRows(0, info.height, metres); !s.ok()) return s.error();
  if (terrain::fillVoids(metres, info.width, info.height).all_void)
    return Error{ErrorCode::kMalformed, info.title + ": holds no data, only voids"};
  return metres;
}

// Rows of the picture are counted from the north, those of the lattice from the south.
Status writeRows(const GroundColours& ground, const terrain::ElevationInfo& info, uint32_t detail,
                 terrain::PictureWriter& writer) {
  const uint32_t width = info.width * detail, height = info.height * detail;
  const double step = 1.0 / detail, first = -0.5 + 0.5 * step;
  std::vector<GroundColours::Colour> rows;
  for (uint32_t top = 0; top < height; top += kPictureRows) {
    const uint32_t count = std::min(kPictureRows, height - top);
    rows.resize(size_t{count} * width);
    terrain::parallelFor(
        count, 0,
        [&](uint64_t i, unsigned) {
          const auto row = static_cast<uint32_t>(i);
          ground.row(first, first + (height - 1 - top - row) * step, step,
                     std::span(rows).subspan(size_t{row} * width, width));
        },
        [](uint64_t) { return true; });
    if (Status s = writer.writeRows(count, rows); !s.ok()) return s;
  }
  return writer.finish();
}

}  // namespace

Status synthPicture(const PictureArguments& arguments) {
  for (const std::filesystem::path& input : arguments.over)
    if (Status s = checkApart(arguments.output, input, "the elevation"); !s.ok()) return s;
  auto source = terrain::openElevation(arguments.over, {});
  if (!source.ok()) return source.error();
  const terrain::ElevationInfo& info = (*source)->info();
  auto writer =
      terrain::createPicture(arguments.output, {info.frame, info.crs_wkt, info.width, info.height}, arguments.detail);
  if (!writer.ok()) return writer.error();
  const auto metres = readGround(**source);
  if (!metres.ok()) return metres.error();
  const GroundColours ground(
      {*metres, info.width, info.height, terrain::sampleSpacing(info.frame, info.width, info.height)}, arguments.seed);
  if (Status s = writeRows(ground, info, arguments.detail, **writer); !s.ok()) return s;
  std::printf("%s: %u x %u texels, %u between two samples\n", arguments.output.c_str(), info.width * arguments.detail,
              info.height * arguments.detail, arguments.detail);
  return {};
}

}  // namespace foreland::apps
