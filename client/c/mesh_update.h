// What changes in a mesh from one version to the next, copied out of the mesh so that another thread can have it. Plain
// data.
#pragma once

#include <cstdint>
#include <glm/vec3.hpp>
#include <vector>

#include "base/bytes.h"
#include "client/drawn_mesh.h"
#include "client/schedule.h"

namespace foreland::client {

// Elements that change in an array: `data` has those of the first range, then those of the second, and so on.
struct ChannelUpdate {
  uint32_t count = 0;  // elements of the whole array
  std::vector<Range> ranges{};
  Bytes data{};
};

// Of the terrain or of all objects; the names of the arrays are those of BlendMesh.
struct PartUpdate {
  bool is_whole = false;  // it needs nothing of the version before
  uint32_t triangles = 0;
  ChannelUpdate from_positions{}, to_positions{}, from_normals{}, to_normals{}, from_moved{}, to_moved{}, from_bends{},
      to_bends{}, parameters{}, indices{};  // an element of the last is a triangle
};

struct MeshUpdate {
  Interval interval;
  uint32_t oldest_version = 0;
  glm::dvec3 origin{0};
  std::vector<ObjectPart> object_parts{};
  PartUpdate terrain{}, objects{};
};

// Takes the changes of the mesh that was drawn last, of `interval`. With `is_whole` of all of it.
MeshUpdate takeUpdate(DrawnMesh& drawn, const Interval& interval, uint32_t oldest_version, bool is_whole);

}  // namespace foreland::client
