#include "client/object_patches.h"

#include <algorithm>
#include <bit>

#include "base/check.h"

namespace foreland::client {

namespace {

constexpr uint32_t kSmallest = 32;
constexpr uint32_t kSpare = 8;  // an eighth more than it has, so that an object does not move at once

void blank(uint32_t begin, uint32_t end, BlendPatch& out) {
  for (uint32_t t = begin; t < end; ++t) out.triangles.push_back({t, {0, 0, 0}});
}

uint32_t sizeOf(Range range) { return range.end - range.begin; }

// Nor does it keep more than four times what it needs.
bool fits(uint32_t count, Range range) {
  constexpr uint32_t kTooLarge = 4;
  return count <= sizeOf(range) && sizeOf(range) <= kTooLarge * std::max(count, kSmallest);
}

}  // namespace

// Powers of two, and between each two of them the one that is half as large again.
uint32_t Ranges::roundUp(uint32_t size, size_t& number) {
  const auto power = static_cast<uint32_t>(std::bit_width(std::max(size, kSmallest) - 1));
  const bool is_between = size <= 3u << (power - 2);
  number = 2 * power + (is_between ? 0 : 1);
  return is_between ? 3u << (power - 2) : 1u << power;
}

Range Ranges::take(uint32_t size) {
  size_t number = 0;
  const uint32_t rounded = roundUp(size, number);
  taken_ += rounded;
  if (free_[number].empty()) {
    count_ += rounded;
    return {count_ - rounded, count_};
  }
  const uint32_t begin = free_[number].back();
  free_[number].pop_back();
  return {begin, begin + rounded};
}

void Ranges::free(Range range) {
  if (sizeOf(range) == 0) return;
  size_t number = 0;
  CHECK_EQ(roundUp(sizeOf(range), number), sizeOf(range));
  taken_ -= sizeOf(range);
  free_[number].push_back(range.begin);
}

bool ObjectPatches::isSparse() const {
  return vertices_.count() > 2 * vertices_.taken() + kFewPlaces ||
         triangles_.count() > 2 * triangles_.taken() + kFewPlaces;
}

void ObjectPatches::write(std::span<ObjectReplica> objects, bool is_whole, const glm::dvec3& origin, MeshPatch& out) {
  places_.resize(objects.size());
  for (size_t i = 0; i < objects.size(); ++i)
    if (objects[i].takeChanged() && !is_whole) write(objects[i], origin, places_[i], out.objects);
  if (is_whole || isSparse()) writeAll(objects, origin, out.objects);
  out.objects.vertex_count = vertices_.count();
  out.objects.triangle_count = triangles_.count();
  for (size_t i = 0; i < objects.size(); ++i)
    out.object_parts.push_back({3 * places_[i].triangles.begin, 3 * places_[i].drawn, objects[i].model()});
}

void ObjectPatches::writeAll(std::span<const ObjectReplica> objects, const glm::dvec3& origin, BlendPatch& out) {
  out.clear();
  out.is_whole = true;
  vertices_ = {}, triangles_ = {};
  for (size_t i = 0; i < objects.size(); ++i) {
    places_[i] = {};
    write(objects[i], origin, places_[i], out);
  }
}

void ObjectPatches::write(const ObjectReplica& object, const glm::dvec3& origin, Place& place, BlendPatch& out) {
  const ObjectPatcher& mesh = object.mesh();
  const bool stays = fits(mesh.vertexCount(), place.vertices) && fits(mesh.triangleCount(), place.triangles);
  scratch_.clear();
  if (!stays) {
    blank(place.triangles.begin, place.triangles.begin + place.drawn, out);
    vertices_.free(place.vertices), triangles_.free(place.triangles);
    place.vertices = vertices_.take(mesh.vertexCount() + mesh.vertexCount() / kSpare);
    place.triangles = triangles_.take(mesh.triangleCount() + mesh.triangleCount() / kSpare);
    place.drawn = 0;
  }
  stays && !mesh.isWhole() ? mesh.write(origin, scratch_) : mesh.writeAll(origin, scratch_);
  const uint32_t first_vertex = place.vertices.begin, first_triangle = place.triangles.begin;
  for (BlendPatch::Position p : scratch_.positions) p.vertex += first_vertex, out.positions.push_back(p);
  for (BlendPatch::Normal n : scratch_.normals) n.vertex += first_vertex, out.normals.push_back(n);
  for (BlendPatch::Parameter p : scratch_.parameters) p.vertex += first_vertex, out.parameters.push_back(p);
  for (BlendPatch::Triangle t : scratch_.triangles) {
    for (uint32_t& corner : t.corners) corner += first_vertex;
    out.triangles.push_back({t.place + first_triangle, t.corners});
  }
  blank(first_triangle + mesh.triangleCount(), first_triangle + place.drawn, out);
  place.drawn = mesh.triangleCount();
}

}  // namespace foreland::client
