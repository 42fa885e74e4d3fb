// The page's files, read once at the start. A request only looks up a path in a table, so it can reach no other file,
// and the I/O thread never waits for a disk. Immutable once filled; any thread.
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
  std::string etag;                                     // quoted; a hash of the content
  std::shared_ptr<const std::string> brotli{}, gzip{};  // the body, compressed; null where that gains nothing
};

class StaticFiles {
 public:
  static constexpr size_t kMaxFiles = 4096;
  static constexpr uint64_t kMaxTotalBytes = 256u << 20;

  StaticFiles() = default;  // no files

  // Reads the regular files below `directory` and compresses them; links are not followed, and names that begin with a
  // dot are left out. An Error if that is no directory, has no
  // index.html or exceeds the limits.
  static Result<StaticFiles> load(const std::filesystem::path& directory);

  // Adds a file under a path that begins with a slash. What is named .bin is compressed; anything else stays as it is:
  // models' images are too large for that at the start.
  void add(std::string path, std::string body);

  // The file of a URL's path, with percent-encoding undone and without the query: "/", "/assets/a.js". The path of a
  // folder finds its index.html. Null if there is no such file. The pointer is valid as long as this object.
  const StaticFile* find(std::string_view path) const;

 private:
  std::map<std::string, StaticFile, std::less<>> files_;  // by path, with a leading slash
};

}  // namespace foreland::server
