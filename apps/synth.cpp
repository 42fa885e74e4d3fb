// foreland-synth: a synthetic mountain landscape as an elevation file, a picture of it or of other elevation, and a
// town as a scene, for the default demo and for tests. Exit codes: 0 done, 2 anything else, with a line on stderr;
// nothing half-written stays.
#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <optional>
#include <vector>

#include "apps/options/command_line.h"
#include "apps/options/foreign_files.h"
#include "apps/options/options.h"
#include "apps/synth_picture.h"
#include "apps/synth_town.h"
#include "proto/refine/surface/objects.h"
#include "terrain/dem/write.h"
#include "terrain/parallel.h"
#include "terrain/synth/landscape.h"

namespace {

using namespace foreland;

constexpr uint32_t kWindowRows = 128;

struct Arguments {
  std::filesystem::path output;
  terrain::LandscapeOptions landscape;
  std::optional<uint32_t> town;  // of so many buildings, instead of a landscape
  apps::PictureArguments picture;
};

int fail(const Error& error) {
  std::fprintf(stderr, "foreland synth: %s\n", error.message.c_str());
  return 2;
}

// Rows of the image are counted from the north, those of the landscape from the south.
void makeWindow(const terrain::Landscape& land, uint32_t top, uint32_t count, std::vector<float>& rows) {
  const uint32_t size = land.info().width;
  rows.resize(size_t{count} * size);
  terrain::parallelFor(
      count, 0,
      [&](uint64_t i, unsigned) {
        const auto row = static_cast<uint32_t>(i);
        land.heights(size - 1 - (top + row), 1, std::span(rows).subspan(size_t{row} * size, size));
      },
      [](uint64_t) { return true; });
}

int synth(const Arguments& arguments) {
  const uint32_t size = arguments.landscape.size;
  auto writer = terrain::createElevationFile({arguments.output, size, size, arguments.landscape.spacing_m});
  if (!writer.ok()) return fail(writer.error());
  const auto land = terrain::Landscape::create(arguments.landscape);
  if (!land.ok()) return fail(land.error());
  std::vector<float> rows;
  float lowest = 1e9f, highest = -1e9f;
  for (uint32_t top = 0; top < size; top += kWindowRows) {
    const uint32_t count = std::min(kWindowRows, size - top);
    makeWindow(**land, top, count, rows);
    const auto [low, high] = std::minmax_element(rows.begin(), rows.end());
    lowest = std::min(lowest, *low);
    highest = std::max(highest, *high);
    if (Status s = (*writer)->writeRows(count, rows); !s.ok()) return fail(s.error());
  }
  if (Status s = (*writer)->finish(); !s.ok()) return fail(s.error());
  std::printf("%s: %u x %u samples, %g m apart, heights %.0f to %.0f m\n", arguments.output.c_str(), size, size,
              arguments.landscape.spacing_m, lowest, highest);
  return 0;
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App app{"Makes a synthetic mountain landscape, or a town.", "foreland synth"};
  Arguments arguments;
  CLI::Option* output =
      app.add_option("-o,--output", arguments.output,
                     "the elevation file to write, OpenEXR or GeoTIFF by its name; with --town, the scene file");
  output->type_name(apps::file("FILE.exr|FILE.tif|FILE.fls"));
  CLI::Option* town = app.add_option("--town", arguments.town,
                                     "make a scene: streets, with this many buildings, on a landscape; -o names the "
                                     "scene file");
  town->type_name(apps::whole("N"))->check(apps::within(1u, uint32_t{proto::ObjectSet::kMaxObjects}));
  app.add_option("--size", arguments.landscape.size, "samples along each side, at least 2")
      ->type_name(apps::whole("N"))
      ->excludes(town)
      ->capture_default_str();
  app.add_option("--spacing", arguments.landscape.spacing_m, "metres between samples")
      ->type_name(apps::number("M"))
      ->check(apps::isFinite())
      ->excludes(town)
      ->capture_default_str();
  app.add_option("--seed", arguments.landscape.seed, "the same seed gives the same bytes")
      ->type_name(apps::whole("S"))
      ->capture_default_str();
  CLI::Option* picture = app.add_option(
      "--imagery", arguments.picture.output,
      "a picture that fits the landscape, for `foreland build --imagery`: forest, meadow, rock and snow");
  picture->type_name(apps::file("PICTURE.tif"))->excludes(town);
  app.add_option("--imagery-detail", arguments.picture.detail, "texels of the picture between two samples")
      ->type_name(apps::whole("N"))
      ->needs(picture)
      ->check(apps::within(1u, 64u))
      ->capture_default_str();
  app.add_option("--over", arguments.picture.over, "make the picture of these elevation files, and no landscape")
      ->type_name(apps::file("ELEVATION"))
      ->needs(picture)
      ->excludes(output);
  const auto exit_code = apps::parseCommandLine(
      app, argc, argv,
      {{"a landscape", "foreland synth -o hills.exr --size 2049 --seed 7"},
       {"a landscape and a picture of it", "foreland synth -o hills.tif --imagery hills-picture.tif"},
       {"a town of 2,000 houses", "foreland synth --town 2000 -o town.fls"},
       {"a picture of other elevation", "foreland synth --imagery picture.tif --over N46E008.hgt"}});
  if (exit_code) return *exit_code;
  if (arguments.output.empty() && arguments.picture.over.empty()) {
    std::fprintf(stderr,
                 "foreland synth: --output is required: the elevation file to write (see foreland synth --help)\n");
    return 2;
  }
  apps::confineTo({}, arguments.picture.over, {arguments.output, arguments.picture.output});
  if (arguments.town) {
    const Status made = apps::synthTown(arguments.output, *arguments.town, arguments.landscape.seed);
    return made.ok() ? 0 : fail(made.error());
  }
  if (arguments.picture.over.empty())
    if (const int code = synth(arguments); code != 0) return code;
  if (arguments.picture.output.empty()) return 0;
  if (arguments.picture.over.empty()) arguments.picture.over = {arguments.output};
  arguments.picture.seed = static_cast<uint32_t>(arguments.landscape.seed);
  const Status made = apps::synthPicture(arguments.picture);
  return made.ok() ? 0 : fail(made.error());
}
