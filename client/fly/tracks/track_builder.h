// What the track readers share: they add fixes in the file's order and notes on what was skipped, and finish() makes a
// Track of them. One owner; used by igc.cpp, gpx.cpp, kml.cpp, geojson.cpp and camera_frames.cpp only.
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "client/fly/tracks/track.h"

namespace foreland::client {

// A fix as it was written. Height or time may be missing.
struct RawFix {
  std::optional<double> time_s = {};  // on any clock; never decreasing in a sound file
  double latitude_deg = 0;
  double longitude_deg = 0;
  std::optional<double> height_m = {};
  size_t line = 0;  // set by TrackBuilder::add
};

class TrackBuilder {
 public:
  explicit TrackBuilder(std::string name) : name_(std::move(name)) {}

  // What places in the file are called where they are no lines: "name: point 3" instead of "name:3".
  void callPlaces(std::string word) { place_ = std::move(word); }
  // Counts a line or point that cannot be used; the first few are noted as "name:line: why".
  void skip(size_t line, std::string_view why);
  void note(const std::string& text) { notes_.push_back(name_ + ": " + text); }
  // Skips fixes off the globe or with absurd heights.
  void add(size_t line, const RawFix& fix);
  bool isFull() const { return fixes_.size() >= Track::kMaxFixes; }

  // Leaves out fixes at 0, 0, unless the track passes there; fills in missing times and heights; drops single fixes
  // whose time repeats or goes back. Where the clock itself stands or goes back the flight goes on at a constant speed.
  // An Error if fewer than two fixes are left.
  Result<Track> finish(std::string_view kind) &&;
  // A track whose cameras have been read, with what was noted.
  Result<Track> finish(Track cameras) &&;

 private:
  Error tooFew(std::string_view expected) const;
  void dropZeros();
  void fillTimes();
  void spreadTimes(size_t first, size_t last);
  void repairTimes();
  TrackHeights fillHeights();

  std::string name_, place_;
  std::vector<RawFix> fixes_;
  std::vector<std::string> notes_;
  size_t skipped_ = 0, repeated_ = 0;
};

}  // namespace foreland::client
