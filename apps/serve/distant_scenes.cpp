#include "apps/serve/distant_scenes.h"

#include <cstdlib>
#include <filesystem>
#include <system_error>
#include <utility>

#include "server/net/steady_clock.h"
#include "terrain/fetch/http_source.h"
#include "terrain/fetch/store_address.h"
#include "terrain/store/distant/sums.h"
#include "terrain/store/distant_scene.h"

namespace foreland::apps {

namespace {

std::string fromEnvironment(const char* name) {
  const char* value = std::getenv(name);
  return value ? value : "";
}

// Without checksums nothing can be served.
Result<Bytes> fetchSums(const terrain::StoreAddress& scene) {
  const terrain::StoreAddress address = scene.withSuffix(terrain::sumsBeside(""));
  auto sums = terrain::fetchWhole(address, terrain::kMostSumsBytes);
  if (sums || sums.error().code != ErrorCode::kNotFound) return sums;
  return Error{ErrorCode::kNotFound,
               sums.error().message +
                   "; it holds the scene's checksums: make it by `foreland sums SCENE.fls`, and copy "
                   "it there beside the scene"};
}

}  // namespace

Result<std::shared_ptr<const terrain::Scene>> openFromStore(const std::string& name, const DistantOptions& options) {
  constexpr unsigned kThreads = 8;
  const auto address = terrain::addressOf(name, fromEnvironment);
  if (!address) return address.error();
  const auto sums = fetchSums(*address);
  if (!sums) return sums.error();
  terrain::ChunkCacheOptions cache;
  cache.cache_bytes = options.cache_bytes;
  std::error_code failed;
  cache.folder =
      options.folder.empty() ? std::filesystem::temp_directory_path(failed) : std::filesystem::path(options.folder);
  if (failed) cache.folder = "/tmp";
  cache.now = server::steadyNow;
  cache.tell = options.tell;
  auto scene = terrain::openDistant(terrain::httpSource(*address), *sums, name, std::move(cache));
  if (scene) (*scene)->supply()->cache().start(kThreads);
  return scene;
}

}  // namespace foreland::apps
