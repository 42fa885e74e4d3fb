// Places of a scene: where its data lie, and points of it in the coordinates of the data's owner. What a host shows of
// a welcome. Pure; any thread; portable to WebAssembly.
#pragma once

#include <array>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <vector>

#include "proto/message/message.h"
#include "proto/space/frame.h"

namespace foreland::client {

struct SceneBox {
  glm::dvec3 low, high;  // scene frame, metres
};

// Box around the data, of a globe around the body; else from a net of lattice positions at both extreme heights.
SceneBox boxOf(const proto::Welcome& welcome, const proto::FrameTransform& transform);

// Corners and centres of the root squares that lie inside the data, in the scene frame: the only relief known before
// the first keyframe. None of a globe.
std::vector<glm::dvec3> landmarksOf(const proto::Welcome& welcome, const proto::FrameTransform& transform);

// A point of the scene in the coordinates of the data's owner.
struct MapPosition {
  double height_m = 0;     // above the zero surface
  glm::dvec2 across{0};    // on an ellipsoid: latitude and longitude, degrees; planar: northing and easting, metres
  glm::dvec2 lattice{0};   // position on the lattice of the data's samples
  glm::dvec3 up{0, 0, 1};  // away from the zero surface
};
MapPosition mapPositionOf(const proto::FrameTransform& transform, const glm::dvec3& point);

// The point of the scene at a place in those coordinates (MapPosition::across) and a height above the zero surface.
glm::dvec3 scenePointOf(const proto::FrameTransform& transform, glm::dvec2 across, double height_m);

// From a geographic scene's axes to the earth's (ECEF), by columns.
std::array<double, 16> ecefOf(const proto::FrameTransform& transform);

}  // namespace foreland::client
