// Makes a path of the camera from a recorded track: resampled, smoothed, looking along the track and a little down, at
// a chosen speed, kept above the ground. Of a recorded camera the path takes over where it looked; that flew over
// another model, so its path is laid on the scene: turned by nothing, its middle on the scene's, as large as nine
// tenths of the data allow, and its zero height at the mean of the ground below. There are two steps, because the
// ground's heights come from the server in between. Pure functions; any thread.
#pragma once

#include <glm/vec2.hpp>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "client/fly/tracks/track.h"
#include "proto/space/frame.h"
#include "proto/space/path.h"
#include "proto/topology/grid.h"

namespace foreland::client {

struct TrackOptions {
  double speed = 1;                    // seconds of the track per second of the flight
  double from_s = 0;                   // where in the track to begin, seconds
  std::optional<double> seconds = {};  // of the flight; the whole track if absent
  std::optional<double> agl_m = {};    // fly this far above ground instead of at the recorded height
  double clearance_m = 20;             // recorded heights lower than this above ground are lifted to it
};

// Where the flight goes, before the ground is known.
struct PlannedTrack {
  Duration step;  // of the flight's time: 100 ms, or more where a Path could not hold so many poses
  std::vector<glm::dvec2> positions = {};  // lattice positions
  std::vector<double> heights_m = {};      // recorded, above the zero surface; of a camera above the mean of the ground
  std::vector<glm::dquat> orientations = {};  // of a camera: its axes to east, north and up; else empty
  // How far the sea, which recorded heights count from, lies above the scene's zero surface at each position; for
  // whoever knows it to fill in. Empty: not at all.
  std::vector<float> undulations_m = {};
  std::vector<std::string> notes = {};
};

struct TrackPath {
  proto::Path path;   // starts at time 0
  size_t lifted = 0;  // poses that were below the clearance
  std::vector<std::string> notes = {};
};

// Over a globe a track goes along great circles from fix to fix. Errors: a projected scene (its relation to latitude
// and longitude is not known here), a camera over a globe, a track outside the data, one that ends before `from_s`, one
// without heights when `agl_m` is absent, options out of range. What lies outside the data is cut off, with a note; of
// several stretches inside, the longest is flown.
Result<PlannedTrack> planTrack(const Track& track, const proto::FrameTransform& frame, const proto::GridShape& shape,
                               const TrackOptions& options);

// `ground_m` has a height for each position. Lifting, and the profile of `agl_m`, follow the ground's upper envelope
// over two seconds, so the camera rises before a ridge and does not shake; it is nowhere lower than the clearance or
// `agl_m` demand.
Result<TrackPath> pathOverGround(const PlannedTrack& plan, const proto::FrameTransform& frame,
                                 std::span<const float> ground_m, const TrackOptions& options);

}  // namespace foreland::client
