// Scenes that `foreland serve` reads from stores (terrain/fetch).
#pragma once

#include <functional>
#include <memory>
#include <string>

#include "base/result.h"
#include "terrain/store/scene.h"

namespace foreland::apps {

struct DistantOptions {
  uint64_t cache_bytes = 0;  // of each scene
  std::string folder;        // of the caches; empty for that of temporary files
  std::function<void(const std::string&)> tell;
};

// Opens the scene at an address (terrain::isInStore) and starts threads that fetch what viewers need of it. Reads a few
// megabytes.
Result<std::shared_ptr<const terrain::Scene>> openFromStore(const std::string& name, const DistantOptions& options);

}  // namespace foreland::apps
