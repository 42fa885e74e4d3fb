#include "apps/build/scene_report.h"

#include <cstdio>

namespace foreland::apps {

void printScene(const terrain::BuildReport& report, const std::filesystem::path& output, double seconds) {
  for (const std::string& note : report.notes) std::fprintf(stderr, "note: %s\n", note.c_str());
  for (const std::string& warning : report.warnings) std::fprintf(stderr, "warning: %s\n", warning.c_str());
  for (const terrain::EpochReport& epoch : report.epochs)
    std::printf("  epoch %s: %llu samples changed, by %.1f m at most, %.3f MB\n", epoch.date.c_str(),
                static_cast<unsigned long long>(epoch.changed_samples), epoch.max_m,
                static_cast<double>(epoch.bytes) * 1e-6);
  if (report.imagery.tiles > 0)
    std::printf("  imagery: %llu tiles, and %llu whose parents show the same\n",
                static_cast<unsigned long long>(report.imagery.stored),
                static_cast<unsigned long long>(report.imagery.tiles - report.imagery.stored));
  std::printf(
      "%s: %u x %u samples, %llu nodes, heights %.1f to %.1f m, %llu voids filled, %.1f MB, id %016llx, %.1f s\n",
      output.c_str(), report.width, report.height, static_cast<unsigned long long>(report.nodes), report.lowest_m,
      report.highest_m, static_cast<unsigned long long>(report.voids_filled),
      static_cast<double>(report.file_bytes) * 1e-6, static_cast<unsigned long long>(report.scene_id), seconds);
}

}  // namespace foreland::apps
