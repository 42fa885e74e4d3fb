#include "terrain/remesh/original/weld_and_triangulate.h"

#include <algorithm>
#include <numeric>
#include <set>
#include <string>
#include <tuple>
#include <unordered_set>
#include <utility>

#include "terrain/remesh/original/triangulate.h"

namespace foreland::terrain {

namespace {

using glm::dvec3;

class Triangulator {
 public:
  Triangulator(const Model& model, OnDefect on_defect, Original& made)
      : model_(model), repairs_(on_defect == OnDefect::kRepair), made_(made) {}

  Status run() {
    weld();
    if (Status status = triangulateFaces(); !status.ok()) return status;
    dropUnusedVertices();
    return {};
  }

 private:
  static Status refuse(std::string what) { return Error{ErrorCode::kMalformed, std::move(what)}; }
  std::string vertexName(uint32_t vertex) const { return model_.vertexName(made_.source_vertices[vertex]); }

  // One vertex for each position that a face uses, in the order of the file.
  void weld() {
    const auto& all = model_.positions;
    std::vector<uint32_t> order(all.size());
    std::iota(order.begin(), order.end(), 0);
    const auto key = [&](uint32_t v) { return std::tuple(all[v].x, all[v].y, all[v].z); };
    std::sort(order.begin(), order.end(),
              [&](uint32_t a, uint32_t b) { return std::tuple(key(a), a) < std::tuple(key(b), b); });
    std::vector<uint32_t> first(all.size());  // of each vertex: the first one at the same position
    for (size_t i = 0; i < order.size(); ++i) {
      const bool is_same = i > 0 && all[order[i]] == all[order[i - 1]];
      first[order[i]] = is_same ? first[order[i - 1]] : order[i];
    }
    std::vector<bool> is_used(all.size());
    for (const Corner& corner : model_.corners) is_used[corner.vertex] = true;
    vertices_.assign(all.size(), kNoIndex);
    for (uint32_t v = 0; v < all.size(); ++v) {
      if (!is_used[v]) continue;
      uint32_t& welded = vertices_[first[v]];
      if (welded == kNoIndex) {
        welded = static_cast<uint32_t>(made_.positions.size());
        made_.positions.push_back(all[v]);
        made_.source_vertices.push_back(v);
      } else {
        ++made_.welded;
      }
      vertices_[v] = welded;
    }
  }

  static uint64_t keyOf(uint32_t a, uint32_t b) { return static_cast<uint64_t>(std::min(a, b)) << 32 | std::max(a, b); }

  // All edges of the model's faces: a diagonal between the same two vertices would make them non-manifold.
  std::unordered_set<uint64_t> outlines() const {
    std::unordered_set<uint64_t> edges;
    if (model_.corners.size() == 3 * model_.faceCount()) return edges;
    for (size_t face = 0; face < model_.faceCount(); ++face) {
      const uint64_t begin = model_.faceBegin(face), end = model_.face_ends[face];
      for (uint64_t c = begin; c < end; ++c) edges.insert(keyOf(vertexAt(c), vertexAt(c + 1 == end ? begin : c + 1)));
    }
    return edges;
  }

  Status triangulateFaces() {
    std::unordered_set<uint64_t> edges = outlines();
    std::set<std::vector<uint32_t>> polygons;
    for (uint32_t face = 0; face < model_.faceCount(); ++face) {
      if (Status status = gatherRing(face); !status.ok()) return status;
      if (ring_.size() < 3)
        dropDegenerate(face);
      else if (repairs_ && ring_.size() > 3 && !polygons.insert(canonicalRing()).second)
        ++made_.repairs.duplicate_faces;
      else if (Status status = triangulateRing(face, edges); !status.ok())
        return status;
    }
    if (made_.faces.empty()) return refuse("has no face with an area; name a model with a surface");
    if (made_.faces.size() > kMaxModelVertices)
      return Error{ErrorCode::kLimit, "more than 134217728 triangles; simplify the model"};
    return {};
  }

  Status triangulateRing(uint32_t face, std::unordered_set<uint64_t>& edges) {
    outline_.clear();
    for (uint64_t c : ring_) outline_.push_back(model_.positions[model_.corners[c].vertex]);
    const auto key = [&](uint32_t i, uint32_t j) { return keyOf(vertexAt(ring_[i]), vertexAt(ring_[j])); };
    auto triangles = triangulate(outline_, [&](uint32_t i, uint32_t j) { return !edges.contains(key(i, j)); });
    if (triangles.empty() && repairs_) {
      if (isLine(outline_)) return dropDegenerate(face), Status();
      triangles = triangulate(outline_, [](uint32_t, uint32_t) { return true; });
    }
    if (triangles.empty())
      return refuse(model_.faceName(face) + " has no area or crosses itself; remove or correct it");
    for (const auto& t : triangles) {
      made_.faces.push_back({vertexAt(ring_[t[0]]), vertexAt(ring_[t[1]]), vertexAt(ring_[t[2]])});
      made_.source_corners.push_back({ring_[t[0]], ring_[t[1]], ring_[t[2]]});
      made_.source_faces.push_back(face);
      if (triangles.size() > 1)
        for (uint32_t k = 0; k < 3; ++k) edges.insert(key(t[k], t[(k + 1) % 3]));
    }
    return {};
  }
  uint32_t vertexAt(uint64_t corner) const { return vertices_[model_.corners[corner].vertex]; }

  // The corners of a face; when repairing, without those that only repeat the one before or turn back to it.
  Status gatherRing(uint32_t face) {
    ring_.clear();
    for (uint64_t c = model_.faceBegin(face); c < model_.face_ends[face]; ++c) ring_.push_back(c);
    if (repairs_) {
      dropRepeatedCorners();
      const uint64_t dropped = model_.face_ends[face] - model_.faceBegin(face) - ring_.size();
      if (ring_.size() < 3) return {};
      made_.repairs.repeated_corners += dropped;
    }
    corners_.clear();
    for (uint64_t c : ring_) corners_.push_back(vertexAt(c));
    std::sort(corners_.begin(), corners_.end());
    const auto twice = std::adjacent_find(corners_.begin(), corners_.end());
    if (twice == corners_.end()) return {};
    return refuse(model_.faceName(face) + " has two corners at the position of " + vertexName(*twice) +
                  "; remove or correct it");
  }
  void dropRepeatedCorners() {
    for (size_t i = 0; i < ring_.size() && ring_.size() >= 3;) {
      const size_t next = (i + 1) % ring_.size(), second = (i + 2) % ring_.size();
      const uint32_t v = vertexAt(ring_[i]);
      const bool repeats = v == vertexAt(ring_[next]), returns = v == vertexAt(ring_[second]);
      if (!repeats && !returns) {
        ++i;
        continue;
      }
      const uint32_t from = model_.corners[ring_[i]].vertex, to = model_.corners[ring_[next]].vertex;
      if (!repeats) made_.degenerate.push_back({from, to, to});
      ring_.erase(ring_.begin() + static_cast<ptrdiff_t>(next));
      if (!repeats) ring_.erase(ring_.begin() + static_cast<ptrdiff_t>((i + 1) % ring_.size()));
      i = 0;
    }
  }
  // The same for any first corner and either direction.
  std::vector<uint32_t> canonicalRing() const {
    std::vector<uint32_t> ring;
    for (uint64_t c : ring_) ring.push_back(vertexAt(c));
    std::rotate(ring.begin(), std::min_element(ring.begin(), ring.end()), ring.end());
    if (ring.back() < ring[1]) std::reverse(ring.begin() + 1, ring.end());
    return ring;
  }
  // Remembers the line that the face is.
  void dropDegenerate(uint32_t face) {
    ++made_.repairs.degenerate_faces;
    const uint64_t end = model_.face_ends[face];
    for (uint64_t c = model_.faceBegin(face); c + 1 < end; ++c) {
      const uint32_t a = model_.corners[c].vertex, b = model_.corners[c + 1].vertex;
      made_.degenerate.push_back({a, b, b});
    }
  }

  // Only faces that were dropped leave vertices that no face uses.
  void dropUnusedVertices() {
    if (made_.repairs.degenerate_faces == 0 && made_.repairs.repeated_corners == 0) return;
    std::vector<uint32_t> kept(made_.positions.size(), kNoIndex);
    for (const Triangle& t : made_.faces)
      for (uint32_t v : t) kept[v] = 0;
    uint32_t count = 0;
    for (uint32_t v = 0; v < kept.size(); ++v) {
      if (kept[v] == kNoIndex) continue;
      made_.positions[count] = made_.positions[v], made_.source_vertices[count] = made_.source_vertices[v];
      kept[v] = count++;
    }
    made_.positions.resize(count), made_.source_vertices.resize(count);
    for (Triangle& t : made_.faces)
      for (uint32_t& v : t) v = kept[v];
  }

  const Model& model_;
  bool repairs_;
  Original& made_;
  std::vector<uint32_t> vertices_;  // of the model's vertices; kNoIndex for those that no face uses
  std::vector<uint64_t> ring_;      // corners of the face that is triangulated
  std::vector<uint32_t> corners_;   // scratch
  std::vector<dvec3> outline_;      // scratch
};

}  // namespace

Status weldAndTriangulate(const Model& model, OnDefect on_defect, Original& made) {
  return Triangulator(model, on_defect, made).run();
}

}  // namespace foreland::terrain
