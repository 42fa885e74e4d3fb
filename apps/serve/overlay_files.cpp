#include "apps/serve/overlay_files.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <fstream>
#include <nlohmann/json.hpp>
#include <string_view>
#include <system_error>
#include <utility>

namespace foreland::apps {
namespace fs = std::filesystem;
namespace {

// Extensions, and how files of these begin; tables may begin with anything.
struct Kind {
  std::string_view extension, begins;
};
constexpr std::array<Kind, 8> kKinds = {{{".geojson", "{"},
                                         {".json", "{"},
                                         {".kml", "<"},
                                         {".gpx", "<"},
                                         {".kmz", "PK"},
                                         {".igc", "A"},
                                         {".csv", ""},
                                         {".tsv", ""}}};

Error refusal(const fs::path& path, ErrorCode code, const std::string& why) {
  return {code, fmt::format("--overlay '{}': {}", path.string(), why)};
}

std::string extensionOf(const fs::path& path) {
  std::string extension = path.extension().string();
  std::transform(extension.begin(), extension.end(), extension.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return extension;
}

Result<const Kind*> kindOf(const fs::path& path) {
  const std::string extension = extensionOf(path);
  const auto found =
      std::find_if(kKinds.begin(), kKinds.end(), [&](const Kind& k) { return k.extension == extension; });
  if (found != kKinds.end()) return &*found;
  return refusal(path, ErrorCode::kInvalidArgument,
                 "pages read .geojson, .json, .kml, .kmz, .gpx, .igc, .csv and .tsv; bring it to GeoJSON, as by "
                 "ogr2ogr -f GeoJSON");
}

Result<std::string> contentOf(const fs::path& path) {
  std::error_code error;
  if (!fs::is_regular_file(path, error)) return refusal(path, ErrorCode::kNotFound, "there is no such file");
  const uint64_t size = fs::file_size(path, error);
  if (error) return refusal(path, ErrorCode::kIo, error.message());
  if (size > kMaxOverlayBytes)
    return refusal(
        path, ErrorCode::kLimit,
        fmt::format("it is larger than {} MiB, which pages read at most; leave something out, or simplify it, as by "
                    "ogr2ogr -simplify",
                    kMaxOverlayBytes >> 20));
  std::ifstream in(path, std::ios::binary);
  std::string body(size, '\0');
  if (!in || !in.read(body.data(), static_cast<std::streamsize>(size)))
    return refusal(path, ErrorCode::kIo, "it cannot be read whole");
  return body;
}

// After a byte order mark and white space, which texts may begin with.
Status beginsAs(const Kind& kind, const fs::path& path, std::string_view body) {
  for (const std::string_view mark : {"\xef\xbb\xbf", "\xff\xfe", "\xfe\xff"})
    if (body.starts_with(mark)) body.remove_prefix(mark.size());
  const size_t first = body.find_first_not_of(std::string_view(" \t\r\n\0", 5));
  if (first != std::string_view::npos && body.substr(first).starts_with(kind.begins)) return {};
  return refusal(path, ErrorCode::kInvalidArgument,
                 kind.begins.empty()
                     ? "it is empty"
                     : fmt::format("it is no {} file, which begins with {}", kind.extension.substr(1), kind.begins));
}

}  // namespace

Result<std::map<std::string, std::string>> overlayFiles(const std::vector<fs::path>& paths) {
  std::map<std::string, std::string> files;
  nlohmann::json list = nlohmann::json::array();
  uint64_t total = 0;
  for (const fs::path& path : paths) {
    const auto kind = kindOf(path);
    if (!kind) return kind.error();
    auto body = contentOf(path);
    if (!body) return body.error();
    if (const Status status = beginsAs(**kind, path, *body); !status.ok()) return status.error();
    if ((total += body->size()) > kMaxOverlaysBytes)
      return refusal(
          path, ErrorCode::kLimit,
          fmt::format("with those before it there are more than {} MiB; leave some out", kMaxOverlaysBytes >> 20));
    const std::string name = fmt::format("{}{}", list.size(), (*kind)->extension);
    list.push_back({{"name", path.filename().string()}, {"path", name}});
    files["/overlays/" + name] = std::move(*body);
  }
  files["/overlays/list.json"] = list.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace);
  return files;
}

}  // namespace foreland::apps
