// Recorded flights: IGC (gliders, paragliders), GPX, KML and GeoJSON (everything else) are read into fixes in time
// order, camera frames (fly-throughs) into cameras. Readers accept any bytes: a line or point that is malformed or
// marked as invalid, or that has no position, is counted and skipped, with a note that names it. Markup that is not
// well-formed, and a track of fewer than two usable fixes, are Errors. Times start at zero and strictly increase, also
// over midnight. Pure functions on text, except readTrack, which opens the file. Any thread.
#pragma once

#include <filesystem>
#include <glm/gtc/quaternion.hpp>
#include <glm/vec3.hpp>
#include <string>
#include <string_view>
#include <vector>

#include "base/result.h"

namespace foreland::client {

struct Fix {
  double time_s = 0;  // since the first fix
  double latitude_rad = 0;
  double longitude_rad = 0;
  double height_m = 0;  // as recorded: usually above sea level
};

// A frame of a camera that flew over a model of its own: lengths are in the model's units, z is up.
struct CameraFrame {
  double time_s = 0;  // since the first frame
  glm::dvec3 eye{0};
  glm::dquat orientation{1, 0, 0, 0};  // camera axes (proto/space/pose.h) to the model's
};

enum class TrackHeights : uint8_t { kRecorded, kMissing };

struct Track {
  static constexpr size_t kMaxFileBytes = 256u << 20;
  static constexpr size_t kMaxFixes = 4'000'000;

  // One of these is empty; the other has at least two, time_s strictly increasing.
  std::vector<Fix> fixes = {};
  std::vector<CameraFrame> cameras = {};
  TrackHeights heights = TrackHeights::kRecorded;
  size_t skipped = 0;                   // lines or points that could not be used
  std::vector<std::string> notes = {};  // for people: what was skipped or assumed, and where
  double seconds() const {
    if (!cameras.empty()) return cameras.back().time_s;
    return fixes.empty() ? 0 : fixes.back().time_s;
  }
};

// Error messages and notes call the file `name`.
Result<Track> parseIgc(std::string_view text, const std::string& name);
// Track points, of all segments; route points if there are none; else waypoints, in the file's order. Points marked as
// having no fix are left out. Points without a time get one at a constant speed between their neighbours, or at 10 m/s
// where these have none either, here and below.
Result<Track> parseGpx(std::string_view text, const std::string& name);

// All lines and tracks (gx:Track, with times) one after another; points if there are none. Heights above the
// ground count as none.
Result<Track> parseKml(std::string_view text, const std::string& name);
// All lines, one after another, with the times of `coordTimes` (togeojson) if there are; points if there are no lines.
// Also sequences of objects, a line each or as RFC 8142 has them. Notes and messages count points from 1.
Result<Track> parseGeoJson(std::string_view text, const std::string& name);

// Camera frames as the programs of H. Hoppe's mesh library write them: lines `F 0`, then the axes forward, left and up,
// the position and the zoom, which is not used; other lines are events. No times are recorded: 30 frames a second.
Result<Track> parseCameraFrames(std::string_view text, const std::string& name);

// By content: a file that starts with markup is GPX or KML, one that starts with a brace (or RFC 8142's mark)
// GeoJSON, one that starts with `F ` has camera frames. Text may be UTF-16, have a byte-order mark and any line ends,
// and be packed by gzip. At most kMaxFileBytes, unpacked.
Result<Track> readTrack(const std::filesystem::path& path);

}  // namespace foreland::client
