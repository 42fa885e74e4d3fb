// `foreland viewshed`: what is seen from a point of a scene, as a GeoTIFF. Exit code 0 when all was written, 2
// otherwise; no file is left half-written. The main thread reads the clock; lines of sight use all processors.
#include <CLI/CLI.hpp>
#include <cstdio>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "apps/options/command_line.h"
#include "apps/options/date.h"
#include "apps/options/options.h"
#include "apps/options/output_file.h"
#include "apps/report/progress_line.h"
#include "apps/viewshed/viewshed_options.h"
#include "server/sight/viewshed.h"
#include "terrain/dem/pictures/write_classes.h"
#include "terrain/parallel.h"

namespace foreland::apps {

namespace {

constexpr uint64_t kMaxCells = uint64_t{1} << 30;
constexpr uint8_t kSeen = 255, kHidden = 0, kNoData = 1;

constexpr const char* kFooter = R"(
From LAT,LON,HEIGHT in degrees and metres above the ground; in planar scenes the map's x and y stand for latitude and longitude.
The file has a byte for each cell: 255 is seen, 0 is hidden, 1 (tagged as no data) lies beyond the radius or the data. Each cell
is a line of sight to its middle, over every sample and object, that ends --target above the ground there.

Planar scenes have the earth's curvature in the lines of sight, geographic ones in their ground. gdal_viewshed's -cc is 1 - K.

Exit code: 0 when all was written, 2 otherwise; no file is left half-written.)";

struct Options {
  std::filesystem::path scene, output;
  ViewshedOptions viewshed;
  std::optional<std::string> date;
  unsigned threads = 0;
};

int fail(const Error& error) {
  std::fprintf(stderr, "foreland viewshed: %s\n", error.message.c_str());
  return 2;
}

std::vector<uint8_t> look(const server::Viewshed& viewshed, unsigned threads) {
  const server::ViewshedGrid& grid = viewshed.grid();
  std::vector<uint8_t> classes(grid.cells(), kNoData);
  ProgressLine progress;
  terrain::parallelFor(
      grid.rows, threads,
      [&](uint64_t row, unsigned) {
        for (uint32_t column = 0; column < grid.columns; ++column) {
          const server::ViewshedCell cell = viewshed.cell(column, static_cast<uint32_t>(row));
          if (cell == server::ViewshedCell::kOutside) continue;
          classes[row * grid.columns + column] = cell == server::ViewshedCell::kSeen ? kSeen : kHidden;
        }
      },
      [&](uint64_t done) {
        progress.show("lines of sight", static_cast<double>(done) / grid.rows);
        return true;
      });
  progress.end();
  return classes;
}

void report(const Options& o, const server::ViewshedGrid& grid, const std::vector<uint8_t>& classes) {
  const auto seen = static_cast<size_t>(std::count(classes.begin(), classes.end(), kSeen));
  const auto outside = static_cast<size_t>(std::count(classes.begin(), classes.end(), kNoData));
  const size_t asked = classes.size() - outside;
  std::printf("%s: %u x %u cells; %zu of %zu seen (%.1f %%)\n", o.output.c_str(), grid.columns, grid.rows, seen, asked,
              asked > 0 ? 100.0 * static_cast<double>(seen) / static_cast<double>(asked) : 0.0);
}

Status checkName(const std::filesystem::path& output) {
  const std::string suffix = output.extension().string();
  if (suffix != ".tif" && suffix != ".tiff")
    return Error{ErrorCode::kUnsupported, output.string() + ": the name of a viewshed must end in .tif"};
  return checkOutput(output, "viewshed");
}

int viewshed(const Options& o) {
  if (Status s = checkName(o.output); !s.ok()) return fail(s.error());
  auto scene = terrain::Scene::open(o.scene);
  if (!scene.ok()) return fail(scene.error());
  if ((*scene)->grid().isCube())
    return fail(
        {ErrorCode::kUnsupported, o.scene.string() + ": a globe, whose faces no GeoTIFF's reference system has"});
  auto question = questionOf(o.viewshed, "--from", **scene);
  if (!question.ok()) return fail(question.error());
  if (o.date) {
    const auto date = parseDateOption(*o.date, o.scene.string(), (*scene)->epochs().epochs());
    if (!date.ok()) return fail(date.error());
    question->scene_time = *date;
  }
  auto objects = server::objectsOf(*scene);
  if (!objects.ok()) return fail(objects.error());
  const server::Hierarchy hierarchy(*scene, proto::ErrorBound::kSpheroid, std::move(*objects));
  const auto grid = server::Viewshed::gridOf(hierarchy, *question, kMaxCells);
  if (!grid.ok()) return fail(grid.error());
  const auto sight = server::SightScene::create(hierarchy);
  if (!sight.ok()) return fail(sight.error());
  const std::vector<uint8_t> classes = look(server::Viewshed(*sight, *question, *grid), o.threads);
  const proto::GridShape& shape = hierarchy.grid().shape();
  const terrain::PictureLattice lattice{(*scene)->frame(), (*scene)->origin().crs_wkt, shape.samples_x,
                                        shape.samples_y};
  if (Status s = terrain::writeClasses(o.output, lattice, {grid->first, grid->step, grid->columns, grid->rows}, classes,
                                       kNoData);
      !s.ok())
    return fail(s.error());
  report(o, *grid, classes);
  return 0;
}

const std::vector<Example> kExamples{
    {"what is seen from the height of a person's eyes, within 10 km",
     "foreland viewshed hills.fls --from 5000,-15000,1.75 -o seen.tif"},
    {"where a mast of 30 m is seen from, cell by cell of 50 m",
     "foreland viewshed hills.fls --from 5000,-15000,30 --target 1.75 --radius 20000 --cell 50 -o seen.tif"}};

}  // namespace

}  // namespace foreland::apps

int main(int argc, char** argv) {
  using namespace foreland::apps;
  Options o;
  CLI::App app("Tells what is seen from a point of a scene, exactly, as a GeoTIFF.", "foreland viewshed");
  app.footer(kFooter);
  app.add_option("SCENE", o.scene, "the scene file")->type_name(file("SCENE.fls"))->required();
  app.add_option("--from", o.viewshed.from, "the eye")->type_name(text("LAT,LON,HEIGHT"))->required();
  app.add_option("-o,--output", o.output, "the file to write")->type_name(file("FILE.tif"))->required();
  addViewshedOptions(app, o.viewshed, "What is asked");
  app.add_option("--cell", o.viewshed.question.cell_m, "width of a cell in metres; by default the elevation's own")
      ->type_name(number("M"))
      ->check(above(0, foreland::server::Viewshed::kMaxRadius_m))
      ->group("What is asked");
  app.add_option("--date", o.date, "in scenes that change in time: of which date the ground is; by default the last")
      ->type_name(text("YYYY-MM-DD"))
      ->group("What is asked");
  app.add_option("--threads", o.threads, "threads that compute; 0 for one per processor")
      ->type_name(whole("N"))
      ->check(within(0u, 1024u))
      ->capture_default_str();
  if (const auto exit_code = parseCommandLine(app, argc, argv, kExamples)) return *exit_code;
  return viewshed(o);
}
