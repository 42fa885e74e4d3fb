#include "apps/options/foreign_track.h"

#include <cmath>
#include <string>
#include <type_traits>
#include <utility>

#include "terrain/fence/confined_child.h"
#include "terrain/fence/file_fence.h"

namespace foreland::apps {

namespace {

using client::CameraFrame;
using client::Fix;
using client::Track;

constexpr size_t kMaxTextBytes = 1u << 20;  // of notes
constexpr size_t kMaxBytes = Track::kMaxFixes * (sizeof(Fix) + sizeof(CameraFrame)) + 2 * kMaxTextBytes;
static_assert(std::is_trivially_copyable_v<Fix> && std::is_trivially_copyable_v<CameraFrame>);

void putText(ByteWriter& out, const std::string& text) {
  out.putVarint(text.size());
  out.putBytes({reinterpret_cast<const uint8_t*>(text.data()), text.size()});
}
std::string getText(ByteReader& in) {
  const ByteSpan bytes = in.getBytes(in.getVarint());
  return {bytes.begin(), bytes.end()};
}

template <class T>
void putAll(ByteWriter& out, const std::vector<T>& values) {
  out.putVarint(values.size());
  for (const T& value : values) out.put(value);
}
template <class T>
std::vector<T> getAll(ByteReader& in) {
  const uint64_t count = in.getVarint();
  std::vector<T> values;
  if (count > in.remaining() / sizeof(T)) return values;
  values.reserve(count);
  for (uint64_t i = 0; i < count; ++i) values.push_back(in.get<T>());
  return values;
}

bool isLawful(const Fix& fix) {
  constexpr double kPi = 3.1416;  // rounded up
  return std::fabs(fix.latitude_rad) <= kPi / 2 && std::fabs(fix.longitude_rad) <= kPi && std::isfinite(fix.height_m);
}
bool isLawful(const CameraFrame& frame) {
  const glm::dvec3& eye = frame.eye;
  const glm::dquat& q = frame.orientation;
  const double length = q.w * q.w + q.x * q.x + q.y * q.y + q.z * q.z;
  return std::isfinite(eye.x) && std::isfinite(eye.y) && std::isfinite(eye.z) && std::fabs(length - 1) < 1e-3;
}
template <class T>
bool areLawful(const std::vector<T>& all) {
  if (all.size() < 2 || all.size() > Track::kMaxFixes || all.front().time_s != 0) return false;
  for (size_t i = 0; i < all.size(); ++i)
    if (!std::isfinite(all[i].time_s) || !isLawful(all[i]) || (i > 0 && !(all[i].time_s > all[i - 1].time_s)))
      return false;
  return true;
}

}  // namespace

Bytes encodeTrack(const Result<Track>& track) {
  Bytes bytes;
  ByteWriter out(bytes);
  out.put<uint8_t>(track.ok());
  if (!track.ok()) {
    out.put(track.error().code);
    putText(out, track.error().message.substr(0, kMaxTextBytes));
    return bytes;
  }
  out.put(track->heights);
  out.putVarint(track->skipped);
  out.putVarint(track->notes.size());
  for (const std::string& note : track->notes) putText(out, note.substr(0, kMaxTextBytes / track->notes.size()));
  putAll(out, track->fixes);
  putAll(out, track->cameras);
  return bytes;
}

Result<Track> decodeTrack(ByteSpan bytes, const std::string& name) {
  const Error senseless{ErrorCode::kMalformed, name + ": its reader gives no track; the file is not to be trusted"};
  ByteReader in(bytes);
  if (in.get<uint8_t>() == 0) {
    const auto code = in.get<ErrorCode>();
    std::string message = getText(in);
    if (!in.atEnd() || code > ErrorCode::kLimit) return senseless;
    return Error{code, std::move(message)};
  }
  Track track{.heights = in.get<client::TrackHeights>()};
  track.skipped = in.getVarint();
  for (uint64_t notes = in.getVarint(); notes > 0 && in.ok(); --notes) track.notes.push_back(getText(in));
  track.fixes = getAll<Fix>(in);
  track.cameras = getAll<CameraFrame>(in);
  const bool is_track =
      track.cameras.empty() ? areLawful(track.fixes) : track.fixes.empty() && areLawful(track.cameras);
  if (!in.atEnd() || !is_track || track.heights > client::TrackHeights::kMissing) return senseless;
  return track;
}

Result<Track> readForeignTrack(const std::filesystem::path& path, TrackReader read) {
  const auto answer = terrain::inConfinedChild({{terrain::FileFence::resolved(path)}, {}}, kMaxBytes,
                                               [&] { return encodeTrack(read(path)); });
  if (!answer.ok()) return Error{answer.error().code, path.string() + ": " + answer.error().message};
  return decodeTrack(*answer, path.string());
}

}  // namespace foreland::apps
