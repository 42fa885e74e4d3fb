#include "apps/synth_town.h"

#include <cinttypes>
#include <cstdio>

#include "apps/options/output_file.h"
#include "apps/report/progress_line.h"
#include "apps/stop_signal.h"
#include "terrain/town/build_town.h"

namespace foreland::apps {

Status synthTown(const std::filesystem::path& output, uint32_t buildings, uint64_t seed) {
  if (Status s = checkOutput(output, "scene file"); !s.ok()) return s;
  catchStopSignals();
  ProgressLine line;
  const auto town = terrain::buildTown({.output = output, .buildings = buildings, .seed = seed},
                                       {.report = [&](std::string_view stage, double done) { line.show(stage, done); },
                                        .keepGoing = [] { return !isStopRequested(); }});
  line.end();
  if (!town.ok()) return town.error();
  for (const terrain::TownModelReport& model : town->models)
    std::printf("  %-14s %4" PRIu64 " placed; %zu inner solids with %.1f %% of the volume; drawn at most %.2f m off\n",
                model.name.c_str(), model.placed, model.solids, 100 * model.volume_share, model.largest_error_m);
  std::printf("%s: %u buildings within %.0f m, %u x %u samples, %.1f MB\n", output.c_str(), buildings, town->radius_m,
              town->scene.width, town->scene.height, static_cast<double>(town->scene.file_bytes) * 1e-6);
  return {};
}

}  // namespace foreland::apps
