// Checks a scene file: every block's checksum, and the invariants that a viewer's distance tests rely on. Reads the
// whole file once. Uses threads of its own while it runs.
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "base/result.h"
#include "terrain/store/scene.h"

namespace foreland::terrain {

struct VerifyReport {
  uint64_t blocks = 0;   // checksums compared
  uint64_t nodes = 0;    // nodes whose invariants were checked
  uint64_t padding = 0;  // unused slots, all of which must be zero
  uint64_t base_vertices = 0;
  uint64_t texels = 0;  // of a surface's image
  uint64_t faults = 0;
  std::vector<std::string> first_faults;  // a sentence each, the same ones for any number of threads
  bool sound() const { return faults == 0; }
};

// Error if the file could not be opened as a scene. Otherwise the report says what was checked and which faults were
// found.
[[nodiscard]] Result<VerifyReport> verifyScene(const std::filesystem::path& path, unsigned threads = 0);

// Opens a scene and checks the checksums alone, at the speed of the disk: a server does so before it serves a scene.
// What was checked is what is returned, whatever happens to the path meanwhile.
[[nodiscard]] Result<std::shared_ptr<const Scene>> openVerified(const std::filesystem::path& path, unsigned threads = 0,
                                                                uint64_t page_cache_bytes = kDefaultPageCacheBytes);

}  // namespace foreland::terrain
