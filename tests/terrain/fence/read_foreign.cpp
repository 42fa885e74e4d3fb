// Reads a foreign file as `foreland build` does, with walls left out, for hostile_files_test.cpp:
//   read_foreign WALLS FILE      WALLS: both, first (FileFence), second (confine), none
// Prints what is said, and exits 0 if the file was read, 1 if not.
#include <cstdio>
#include <filesystem>
#include <string>
#include <vector>

#include "terrain/dem/formats/gdal_raster.h"
#include "terrain/dem/open.h"
#include "terrain/fence/confine.h"
#include "terrain/fence/file_fence.h"

using namespace foreland;

int main(int argc, char** argv) {
  if (argc != 3) return 3;
  const std::string walls = argv[1];
  const std::filesystem::path file = argv[2];
  const bool has_first = walls == "both" || walls == "first", has_second = walls == "both" || walls == "second";
  if (has_second) {
    const terrain::FileFence fence(std::vector{file});
    const auto missing = terrain::confine({fence.folders(), {}});
    for (const std::string& m : missing) std::printf("missing: %s\n", m.c_str());
  }
  terrain::registerGdalDrivers(!has_first);
  terrain::OpenOptions options;
  options.is_fenced = has_first;
  const auto source = terrain::openElevation({file}, options);
  if (!source.ok()) std::printf("%s\n", source.error().message.c_str());
  return source.ok() ? 0 : 1;
}
