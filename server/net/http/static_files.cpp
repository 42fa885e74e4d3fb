#include "server/net/http/static_files.h"

#include <fmt/format.h>

#include <array>
#include <fstream>
#include <system_error>
#include <utility>

#include "base/fnv1a.h"
#include "server/net/http/compression.h"

namespace foreland::server {
namespace fs = std::filesystem;
namespace {

std::string contentType(const fs::path& path) {
  static constexpr std::array<std::pair<std::string_view, std::string_view>, 16> kTypes = {{
      {".html", "text/html; charset=utf-8"},
      {".js", "text/javascript; charset=utf-8"},
      {".mjs", "text/javascript; charset=utf-8"},
      {".css", "text/css; charset=utf-8"},
      {".json", "application/json"},
      {".map", "application/json"},
      {".webmanifest", "application/manifest+json"},
      {".wasm", "application/wasm"},
      {".png", "image/png"},
      {".jpg", "image/jpeg"},
      {".webp", "image/webp"},
      {".svg", "image/svg+xml"},
      {".ico", "image/x-icon"},
      {".woff2", "font/woff2"},
      {".txt", "text/plain; charset=utf-8"},
      {".md", "text/plain; charset=utf-8"},
  }};
  for (const auto& [extension, type] : kTypes)
    if (path.extension() == extension) return std::string(type);
  return "application/octet-stream";
}

// Vite names the files in assets/ by a hash of their content; the other names stay when their content changes.
std::string cacheControl(std::string_view path) {
  return path.starts_with("/assets/") ? "public, max-age=31536000, immutable" : "no-cache";
}

std::string etagOf(const std::string& body) {
  Fnv1a hash;
  hash.add(body);
  return fmt::format("\"{:016x}-{:x}\"", hash.value(), body.size());
}

// Not compressed.
StaticFile fileOf(const std::string& path, std::string body) {
  const std::string etag = etagOf(body);
  return {std::make_shared<const std::string>(std::move(body)), contentType(path), cacheControl(path), etag};
}

Error unreadable(const fs::path& path, const std::string& why) {
  return {ErrorCode::kIo, fmt::format("cannot read the page's file '{}': {}", path.string(), why)};
}

Result<std::string> readWhole(const fs::path& path, uint64_t size) {
  std::ifstream in(path, std::ios::binary);
  std::string body(size, '\0');
  if (!in || !in.read(body.data(), static_cast<std::streamsize>(size)))
    return unreadable(path, "it cannot be read whole");
  return body;
}

}  // namespace

Result<StaticFiles> StaticFiles::load(const fs::path& directory) {
  std::error_code error;
  if (!fs::is_directory(directory, error))
    return Error{ErrorCode::kNotFound,
                 fmt::format("there is no directory '{}' with the page; build it with ./demo or name "
                             "another one with --web",
                             directory.string())};
  StaticFiles result;
  uint64_t total = 0;
  auto it = fs::recursive_directory_iterator(directory, error);
  for (; !error && it != fs::recursive_directory_iterator(); it.increment(error)) {
    if (it->path().filename().native().starts_with('.')) {
      it.disable_recursion_pending();
      continue;
    }
    if (!fs::is_regular_file(it->symlink_status(error))) continue;
    const uint64_t size = it->file_size(error);
    if (error) return unreadable(it->path(), error.message());
    total += size;
    if (total > kMaxTotalBytes || result.files_.size() == kMaxFiles)
      return Error{ErrorCode::kLimit,
                   fmt::format("'{}' is too large for a page: at most {} files and {} MiB are served",
                               directory.string(), kMaxFiles, kMaxTotalBytes >> 20)};
    auto body = readWhole(it->path(), size);
    if (!body) return body.error();
    std::string path = "/";  // not by `+`, for which g++ 12 gives a false warning
    path += it->path().lexically_relative(directory).generic_string();
    StaticFile file = fileOf(path, std::move(*body));
    file.brotli = compressBrotli(*file.body);
    file.gzip = compressGzip(*file.body);
    result.files_[std::move(path)] = std::move(file);
  }
  if (error) return unreadable(directory, error.message());
  if (!result.files_.contains("/index.html"))
    return Error{ErrorCode::kNotFound,
                 fmt::format("'{}' holds no index.html; build the page with ./demo or name another "
                             "directory with --web",
                             directory.string())};
  return result;
}

void StaticFiles::add(std::string path, std::string body) {
  StaticFile file = fileOf(path, std::move(body));
  if (fs::path(path).extension() == ".bin") {
    file.brotli = compressBrotli(*file.body);
    file.gzip = compressGzip(*file.body);
  }
  files_[std::move(path)] = std::move(file);
}

const StaticFile* StaticFiles::find(std::string_view path) const {
  if (path.empty() || path.front() != '/') return nullptr;
  auto found = files_.find(path);
  if (found == files_.end() && path.back() == '/') found = files_.find(std::string(path) + "index.html");
  return found == files_.end() ? nullptr : &found->second;
}

}  // namespace foreland::server
