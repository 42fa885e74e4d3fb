#include "client/mesh/patch/blend_patch.h"

#include <algorithm>
#include <bit>

#include "base/check.h"

namespace foreland::client {

namespace {

// A host that does not ask for changes any more is not to collect them for ever.
constexpr size_t kMaxNoted = 4;
constexpr size_t kTriangleBytes = 3 * sizeof(uint32_t);

// Makes ranges of the elements, joining those that are less than `gap` elements apart. They are marked as bits, which
// are read in order: many elements come more than once. O(elements + count / 64).
void rangesOf(const std::vector<uint32_t>& elements, size_t gap, size_t count, std::vector<Range>& out) {
  out.clear();
  std::vector<uint64_t> marks(count / 64 + 1);
  for (uint32_t e : elements)
    if (e < count) marks[e / 64] |= uint64_t{1} << e % 64;
  for (size_t w = 0; w < marks.size(); ++w)
    for (uint64_t word = marks[w]; word != 0; word &= word - 1) {
      const auto e = static_cast<uint32_t>(64 * w + static_cast<size_t>(std::countr_zero(word)));
      if (out.empty() || e > out.back().end + gap) out.push_back({e, e});
      out.back().end = e + 1;
    }
}

// Calls fetch(), which is to load what write() will need, some elements ahead of it.
template <class T, class Fetch, class Write>
void forEach(const std::vector<T>& all, const Fetch& fetch, const Write& write) {
  constexpr size_t kAhead = 12;
  for (size_t i = 0; i < all.size(); ++i) {
    if (i + kAhead < all.size()) fetch(all[i + kAhead]);
    write(all[i]);
  }
}

size_t countOf(const std::vector<Range>& ranges) {
  size_t count = 0;
  for (const Range& r : ranges) count += r.end - r.begin;
  return count;
}

}  // namespace

void ChangedRanges::clear() {
  for (auto* ranges : {&from_positions, &to_positions, &bends, &from_normals, &to_normals, &parameters, &triangles})
    ranges->clear();
  tells_moved = false;
}

size_t ChangedRanges::bytes() const {
  return (countOf(from_positions) + countOf(to_positions)) * (sizeof(glm::vec4) + (tells_moved ? sizeof(float) : 0)) +
         countOf(bends) * sizeof(BlendPatch::Bend) + (countOf(from_normals) + countOf(to_normals)) * sizeof(uint32_t) +
         countOf(parameters) * sizeof(glm::vec2) + countOf(triangles) * kTriangleBytes;
}

size_t ChangedRanges::count() const {
  return from_positions.size() + to_positions.size() + bends.size() + from_normals.size() + to_normals.size() +
         parameters.size() + triangles.size();
}

size_t bytesOf(const BlendMesh& mesh) {
  const auto of = [](const auto& array) { return array.size() * sizeof(array[0]); };
  return of(mesh.from_positions) + of(mesh.to_positions) + of(mesh.from_moved) + of(mesh.to_moved) +
         of(mesh.from_bends) + of(mesh.to_bends) + of(mesh.from_normals) + of(mesh.to_normals) + of(mesh.parameters) +
         of(mesh.indices);
}

void PatchedMesh::resize(const BlendPatch& patch) {
  if (patch.is_whole) {
    *mesh_ = {};
    for (auto* resting : {&moving_, &turning_, &bending_}) resting->clear();
    is_all_changed_ = true;
  }
  const size_t bends = patch.tells_bends ? patch.vertex_count : 0;
  if (mesh_->from_bends.empty() != (bends == 0)) is_all_changed_ = true;
  mesh_->from_bends.resize(bends);
  mesh_->to_bends.resize(bends);
  mesh_->from_positions.resize(patch.vertex_count);
  mesh_->to_positions.resize(patch.vertex_count);
  mesh_->from_moved.resize(patch.tells_moved ? patch.vertex_count : 0);
  mesh_->to_moved.resize(patch.tells_moved ? patch.vertex_count : 0);
  mesh_->from_normals.resize(patch.vertex_count);
  mesh_->to_normals.resize(patch.vertex_count);
  mesh_->parameters.resize(patch.vertex_count);
  mesh_->indices.resize(size_t{3} * patch.triangle_count);
}

// What a vertex ended with is what it begins with.
void PatchedMesh::settle() {
  for (uint32_t v : moving_) mesh_->from_positions[v] = mesh_->to_positions[v];
  if (!mesh_->from_moved.empty())
    for (uint32_t v : moving_) mesh_->from_moved[v] = mesh_->to_moved[v];
  for (uint32_t v : turning_) mesh_->from_normals[v] = mesh_->to_normals[v];
  if (!mesh_->from_bends.empty())
    for (uint32_t v : bending_) mesh_->from_bends[v] = mesh_->to_bends[v] = glm::vec3(0);
  if (!is_all_changed_) {
    from_positions_.insert(from_positions_.end(), moving_.begin(), moving_.end());
    from_normals_.insert(from_normals_.end(), turning_.begin(), turning_.end());
    bends_.insert(bends_.end(), bending_.begin(), bending_.end());
  }
  for (auto* resting : {&moving_, &turning_, &bending_}) resting->clear();
}

void PatchedMesh::apply(const BlendPatch& patch) {
  resize(patch);
  settle();
  if (noted() > kMaxNoted * mesh_->parameters.size()) clearChanges(), is_all_changed_ = true;
  const bool notes = !is_all_changed_;
  glm::vec4 *from_positions = mesh_->from_positions.data(), *to_positions = mesh_->to_positions.data();
  forEach(
      patch.positions,
      [&](const BlendPatch::Position& p) {
        __builtin_prefetch(from_positions + p.vertex), __builtin_prefetch(to_positions + p.vertex);
      },
      [&](const BlendPatch::Position& p) {
        if (p.from != p.to) moving_.push_back(p.vertex);
        if (notes && from_positions[p.vertex] != p.from) from_positions_.push_back(p.vertex);
        if (notes && to_positions[p.vertex] != p.to) to_positions_.push_back(p.vertex);
        from_positions[p.vertex] = p.from;
        to_positions[p.vertex] = p.to;
      });
  applyMoved(patch);
  applyBends(patch);
  uint32_t *from_normals = mesh_->from_normals.data(), *to_normals = mesh_->to_normals.data();
  forEach(
      patch.normals,
      [&](const BlendPatch::Normal& n) {
        __builtin_prefetch(from_normals + n.vertex), __builtin_prefetch(to_normals + n.vertex);
      },
      [&](const BlendPatch::Normal& n) {
        if (n.from != n.to) turning_.push_back(n.vertex);
        if (notes && from_normals[n.vertex] != n.from) from_normals_.push_back(n.vertex);
        if (notes && to_normals[n.vertex] != n.to) to_normals_.push_back(n.vertex);
        from_normals[n.vertex] = n.from;
        to_normals[n.vertex] = n.to;
      });
  for (const BlendPatch::Parameter& p : patch.parameters) {
    if (notes) parameters_.push_back(p.vertex);
    mesh_->parameters[p.vertex] = p.parameter;
  }
  uint32_t* indices = mesh_->indices.data();
  forEach(
      patch.triangles, [&](const BlendPatch::Triangle& t) { __builtin_prefetch(indices + 3 * size_t{t.place}); },
      [&](const BlendPatch::Triangle& t) {
        if (notes) triangles_.push_back(t.place);
        std::copy(t.corners.begin(), t.corners.end(), indices + 3 * size_t{t.place});
      });
}

// A vertex that moves in another way than its position does is noted as one whose position changes.
void PatchedMesh::applyMoved(const BlendPatch& patch) {
  const bool notes = !is_all_changed_;
  for (size_t i = 0; i < patch.moved.size(); ++i) {
    const uint32_t v = patch.positions[i].vertex;
    const BlendPatch::Moved& m = patch.moved[i];
    if (m.from != m.to && patch.positions[i].from == patch.positions[i].to) moving_.push_back(v);
    if (notes && mesh_->from_moved[v] != m.from) from_positions_.push_back(v);
    if (notes && mesh_->to_moved[v] != m.to) to_positions_.push_back(v);
    mesh_->from_moved[v] = m.from;
    mesh_->to_moved[v] = m.to;
  }
}

void PatchedMesh::applyBends(const BlendPatch& patch) {
  for (size_t i = 0; i < patch.bends.size(); ++i) {
    const uint32_t v = patch.positions[i].vertex;
    const BlendPatch::Bend& bend = patch.bends[i];
    if (!is_all_changed_ && (mesh_->from_bends[v] != bend.from || mesh_->to_bends[v] != bend.to)) bends_.push_back(v);
    mesh_->from_bends[v] = bend.from;
    mesh_->to_bends[v] = bend.to;
    if (bend.from != glm::vec3(0) || bend.to != glm::vec3(0)) bending_.push_back(v);
  }
}

size_t PatchedMesh::noted() const {
  return from_positions_.size() + to_positions_.size() + bends_.size() + from_normals_.size() + to_normals_.size() +
         parameters_.size() + triangles_.size();
}

void PatchedMesh::collectChanges(size_t gap, ChangedRanges& out) {
  out.clear();
  if (is_all_changed_) return;
  const size_t vertices = mesh_->from_positions.size();
  out.tells_moved = !mesh_->from_moved.empty();
  rangesOf(from_positions_, gap / sizeof(glm::vec4), vertices, out.from_positions);
  rangesOf(to_positions_, gap / sizeof(glm::vec4), vertices, out.to_positions);
  rangesOf(bends_, gap / sizeof(glm::vec3), mesh_->from_bends.size(), out.bends);
  rangesOf(from_normals_, gap / sizeof(uint32_t), vertices, out.from_normals);
  rangesOf(to_normals_, gap / sizeof(uint32_t), vertices, out.to_normals);
  rangesOf(parameters_, gap / sizeof(glm::vec2), vertices, out.parameters);
  rangesOf(triangles_, gap / kTriangleBytes, mesh_->triangleCount(), out.triangles);
}

void PatchedMesh::clearChanges() {
  for (auto* elements :
       {&from_positions_, &to_positions_, &bends_, &from_normals_, &to_normals_, &parameters_, &triangles_})
    elements->clear();
  is_all_changed_ = false;
}

}  // namespace foreland::client
