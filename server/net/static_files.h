// The page's files, read once at the start. A request only looks a name up in a table, so no request can reach any
// other file, and the I/O thread never waits for a disk. Immutable; any thread.
#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <memory>
#include <string>
#include <string_view>

#include "base/result.h"

namespace foreland::server {

struct StaticFile {
  std::shared_ptr<const std::string> body;
  std::string content_type;
  std::string cache_control;
  std::string etag;  // quoted; of the content
};

class StaticFiles {
 public:
  static constexpr size_t kMaxFiles = 4096;
  static constexpr uint64_t kMaxTotalBytes = 256u << 20;

  StaticFiles() = default;  // no files

  // Regular files below `directory`, links not followed. Refuses what is not a directory, lacks index.html or exceeds
  // the limits.
  static Result<StaticFiles> load(const std::filesystem::path& directory);

  // A file that is not the page's own.
  void add(std::string path, std::string body);

  // `path` as in a URL, percent-encoding undone, without the query: "/", "/assets/a.js". A folder's path finds its
  // index.html. Nothing if there is no such file. The pointer lives as long as this.
  const StaticFile* find(std::string_view path) const;

 private:
  std::map<std::string, StaticFile, std::less<>> files_;  // by path with a leading slash
};

}  // namespace foreland::server
