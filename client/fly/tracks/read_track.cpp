// From a file to the text of a track: what is packed by gzip is unpacked, and what is UTF-16 becomes UTF-8.
#include <zlib.h>

#include <algorithm>
#include <fstream>
#include <string>
#include <system_error>

#include "base/lines.h"
#include "base/utf8.h"
#include "client/fly/tracks/track.h"

namespace foreland::client {

namespace {

constexpr size_t kMaxBytes = Track::kMaxFileBytes;

Error tooLarge(const std::string& name) {
  return {ErrorCode::kLimit, name + ": larger than 256 MiB; cut the track into parts"};
}

Result<std::string> readBytes(const std::filesystem::path& path) {
  std::error_code error;
  if (std::filesystem::is_directory(path, error))
    return Error{ErrorCode::kInvalidArgument, path.string() + ": is a directory; name a track's file"};
  const uintmax_t size = std::filesystem::file_size(path, error);
  if (error) return Error{ErrorCode::kNotFound, path.string() + ": " + error.message()};
  if (size > kMaxBytes) return tooLarge(path.string());
  std::string bytes(size, '\0');
  std::ifstream in(path, std::ios::binary);
  in.read(bytes.data(), static_cast<std::streamsize>(size));
  if (!in) return Error{ErrorCode::kIo, path.string() + ": cannot be read"};
  return bytes;
}

// All members of a gzip file. Zeros behind them are padding.
Result<std::string> unpacked(const std::string& bytes, const std::string& name) {
  z_stream stream{};
  constexpr int kGzip = 16 + MAX_WBITS;
  if (inflateInit2(&stream, kGzip) != Z_OK) return Error{ErrorCode::kLimit, name + ": not enough memory to unpack it"};
  stream.next_in = reinterpret_cast<Bytef*>(const_cast<char*>(bytes.data()));
  stream.avail_in = static_cast<uInt>(bytes.size());
  std::string text;
  int result = Z_OK;
  std::string block(1u << 16, '\0');
  while (result == Z_OK && text.size() <= kMaxBytes) {
    stream.next_out = reinterpret_cast<Bytef*>(block.data()), stream.avail_out = static_cast<uInt>(block.size());
    result = inflate(&stream, Z_NO_FLUSH);
    text.append(block, 0, block.size() - stream.avail_out);
    if (result == Z_STREAM_END && stream.avail_in > 0 && *stream.next_in == 0x1f) result = inflateReset(&stream);
  }
  inflateEnd(&stream);
  if (text.size() > kMaxBytes) return tooLarge(name);
  if (result != Z_STREAM_END)
    return Error{ErrorCode::kMalformed, name + ": its gzip data is damaged or cut short; copy it again"};
  return text;
}

// The name of the outermost element of markup, without its prefix; empty if there is none.
std::string_view firstElement(std::string_view text) {
  for (size_t at = text.find('<'); at < text.size(); at = text.find('<', at + 1)) {
    const std::string_view rest = text.substr(at + 1);
    if (rest.starts_with("!--")) at = std::min(text.find("-->", at), text.size());
    if (rest.starts_with('!') || rest.starts_with('?')) continue;
    const std::string_view name = rest.substr(0, rest.find_first_of(" \t\r\n/>"));
    return name.substr(name.find(':') == std::string_view::npos ? 0 : name.find(':') + 1);
  }
  return {};
}

// The outermost element of a KML file, or of a part of one.
bool isKml(std::string_view element) {
  constexpr std::string_view kElements[] = {"kml", "Document", "Folder", "Placemark"};
  return std::find(std::begin(kElements), std::end(kElements), element) != std::end(kElements);
}

bool hasFixLine(std::string_view text) {
  Lines lines(text);
  for (std::string_view line; lines.next(line);)
    if (line.starts_with('B')) return true;
  return false;
}

}  // namespace

Result<Track> readTrack(const std::filesystem::path& path) {
  const std::string name = path.string();
  auto bytes = readBytes(path);
  if (bytes.ok() && bytes->starts_with("\x1f\x8b")) bytes = unpacked(*bytes, name);
  if (!bytes.ok()) return bytes.error();
  if (bytes->starts_with("PK\x03\x04"))
    return Error{ErrorCode::kUnsupported,
                 name + ": is a ZIP archive, as KMZ is; unpack it and name the .kml file in it"};
  std::string storage;
  const auto text = asUtf8(*bytes, storage);
  if (!text.ok()) return Error{text.error().code, name + ": " + text.error().message};
  const std::string_view content = text->substr(std::min(text->find_first_not_of(" \t\r\n"), text->size()));
  if (content.starts_with('<')) return isKml(firstElement(content)) ? parseKml(*text, name) : parseGpx(*text, name);
  if (content.starts_with('{') || content.starts_with('\x1e')) return parseGeoJson(*text, name);
  if (content.starts_with("F ")) return parseCameraFrames(*text, name);
  if (!hasFixLine(*text))
    return Error{ErrorCode::kMalformed,
                 name + ": no track: expected IGC, GPX, KML, GeoJSON or camera frames, packed by gzip or not"};
  return parseIgc(*text, name);
}

}  // namespace foreland::client
