// The objects' part of a keyframe mesh by change. Each object has a range of vertices and one of triangles, with room
// to grow; one that outgrows its ranges, or needs less than a quarter of one, moves to others, and what it leaves is
// taken again by objects of about its size. Triangles that nobody draws have three times the same corner. There are at
// most twice as many places as in ranges that are taken, plus kFewPlaces.
//
// One owner. write(): O(what changes, and objects).
#pragma once

#include <array>
#include <span>
#include <vector>

#include "client/mesh/patch/blend_patch.h"
#include "client/object_replica.h"

namespace foreland::client {

// Ranges of numbers, of few sizes, so that free ones fit again.
class Ranges {
 public:
  // At least as large as asked for.
  Range take(uint32_t size);
  void free(Range range);
  // One past the largest number; how many are in ranges that are taken.
  uint32_t count() const { return count_; }
  uint32_t taken() const { return taken_; }

 private:
  static uint32_t roundUp(uint32_t size, size_t& number);

  std::array<std::vector<uint32_t>, 64> free_;  // by size: the ranges' beginnings
  uint32_t count_ = 0, taken_ = 0;
};

class ObjectPatches {
 public:
  // Writes what changes in the objects that have changed; all objects if `is_whole`, or if the mesh has become sparse.
  void write(std::span<ObjectReplica> objects, bool is_whole, const glm::dvec3& origin, MeshPatch& out);

 private:
  struct Place {
    Range vertices{0, 0}, triangles{0, 0};
    uint32_t drawn = 0;  // of the triangles
  };
  void writeAll(std::span<const ObjectReplica> objects, const glm::dvec3& origin, BlendPatch& out);
  void write(const ObjectReplica& object, const glm::dvec3& origin, Place& place, BlendPatch& out);
  bool isSparse() const;

  std::vector<Place> places_;  // by object
  Ranges vertices_, triangles_;
  BlendPatch scratch_;
};

}  // namespace foreland::client
