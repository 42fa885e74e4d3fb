// The triangles of a mesh that changes: each has a place and keeps it. Places are dense: where triangles were removed
// and no new ones came, the last ones move in. One owner; all is O(1) a triangle.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "base/check.h"
#include "client/mesh/patch/blend_patch.h"
#include "client/mesh/patch/free_places.h"

namespace foreland::client {

class TrianglePlaces {
 public:
  using Corners = std::array<uint32_t, 3>;

  // `owner` is whatever finds who keeps the place.
  uint32_t add(const Corners& corners, uint32_t owner) {
    const uint32_t place = takePlace(triangles_, free_);
    triangles_[place].corners = corners;
    triangles_[place].owner = owner;
    touch(place);
    return place;
  }
  void remove(uint32_t place) {
    triangles_[place].owner = kFree;
    free_.push_back(place);
  }
  // Closes the holes, telling moved(owner, old place, new place), and writes what has changed since the last call.
  template <class Moved>
  void finish(const Moved& moved, BlendPatch& out);

  uint32_t count() const { return static_cast<uint32_t>(triangles_.size()); }
  // Begins to load a triangle that will be needed soon.
  void fetch(uint32_t place) const { __builtin_prefetch(&triangles_[place]); }
  size_t bytes() const {
    return triangles_.capacity() * sizeof(Triangle) + (free_.capacity() + touched_.capacity()) * sizeof(uint32_t);
  }

  static constexpr uint32_t kFree = 0xffffffffu;

 private:
  struct Triangle {
    Corners corners{};
    uint32_t owner = kFree;
    bool is_touched = false;
  };
  void touch(uint32_t place) {
    if (triangles_[place].is_touched) return;
    triangles_[place].is_touched = true;
    touched_.push_back(place);
  }

  std::vector<Triangle> triangles_;
  std::vector<uint32_t> free_, touched_;
};

template <class Moved>
void TrianglePlaces::finish(const Moved& moved, BlendPatch& out) {
  for (uint32_t hole : free_) {
    while (!triangles_.empty() && triangles_.back().owner == kFree) triangles_.pop_back();
    if (hole >= count()) continue;
    moved(triangles_.back().owner, count() - 1, hole);
    triangles_[hole].corners = triangles_.back().corners;
    triangles_[hole].owner = triangles_.back().owner;
    touch(hole);
    triangles_.pop_back();
  }
  free_.clear();
  while (!triangles_.empty() && triangles_.back().owner == kFree) triangles_.pop_back();
  for (uint32_t place : touched_) {
    if (place >= count()) continue;
    triangles_[place].is_touched = false;
    out.triangles.push_back({place, triangles_[place].corners});
  }
  touched_.clear();
  out.triangle_count = count();
}

}  // namespace foreland::client
