// What is seen from here: lines of sight between points and viewsheds, which a client asks for and the server answers
// exactly, on ground and objects at full resolution. Plain values; their bytes are control messages (control.h). Pure;
// any thread; portable to WebAssembly.
#pragma once

#include <cstdint>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <string>
#include <vector>

#include "base/bytes.h"
#include "base/time.h"

namespace foreland::proto {

inline constexpr size_t kMaxSightPairs = 4096;
inline constexpr uint32_t kMaxViewshedCells = 1u << 22, kMaxCellsTold = 1u << 16;  // of one reply
inline constexpr double kMaxSightHeight_m = 1e6, kMaxSightRadius_m = 1e7, kMinSightLength_m = 1e-3;
// By which light bends around the earth, usually: the share of the earth's curvature.
inline constexpr double kUsualRefraction = 1.0 / 7;

enum class Above : uint8_t { kGround = 0, kZeroSurface = 1 };

struct SightRequest {
  uint32_t id = 0;
  // From, to, from, to, ...: lattice position and height, metres. At most kMaxSightPairs pairs.
  std::vector<glm::dvec3> ends;
  Above above = Above::kGround;
  double refraction = kUsualRefraction;
  Time scene_time{};  // in scenes that change in time, of the ground and the objects; before the first epoch as at it
};

struct SightHit {
  static constexpr int32_t kNothing = -2, kUnknown = -3, kGround = -1;  // unknown: an end lies beyond the data
  glm::dvec3 position{0};                                               // scene frame; of the first point that hides
  int32_t what = kNothing;                                              // an object's number, or one of the above
};

struct SightReply {
  uint32_t id = 0;
  std::string error;             // why there is no answer; otherwise empty
  std::vector<glm::dvec3> ends;  // those of the request in the scene frame
  std::vector<SightHit> hits;    // of each pair
};

struct ViewshedRequest {
  uint32_t id = 0;
  glm::dvec2 observer{0};                  // lattice position
  double observer_m = 1.75, target_m = 0;  // of the eye and of what is looked at, above the ground
  double radius_m = 10e3, cell_m = 30;
  double refraction = kUsualRefraction;
  Time scene_time{};
};

enum class ViewshedCell : uint8_t { kHidden = 0, kSeen = 1, kOutside = 2 };  // of the radius, or of the data

// Cells by their middles: lattice positions first + (i, j) * step, row by row from the south.
struct ViewshedReply {
  uint32_t id = 0;
  std::string error;  // why there is no answer; otherwise empty
  glm::dvec2 first{0}, step{1};
  uint32_t columns = 0, rows = 0;  // columns * rows is at most kMaxViewshedCells
  uint32_t begin = 0;              // the first cell told; replies to a request follow on each other
  std::vector<ViewshedCell> cells;
};

// The client no longer wants an answer; parts of it may be on the way.
struct RequestCancel {
  uint32_t id = 0;
};

Bytes encode(const SightRequest& message);
Bytes encode(const ViewshedRequest& message);
Bytes encode(const RequestCancel& message);
Bytes encode(const SightReply& message);
Bytes encode(const ViewshedReply& message);

}  // namespace foreland::proto
