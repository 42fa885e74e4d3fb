#include "proto/topology/base_mesh.h"

#include <algorithm>
#include <string>
#include <utility>

#include "base/sort.h"

namespace foreland::proto {

namespace {

Error refusal(const std::string& what) { return {ErrorCode::kMalformed, "base mesh: " + what}; }

std::string number(uint32_t n) { return std::to_string(n); }

}  // namespace

Result<BaseMesh> BaseMesh::create(uint32_t vertex_count, std::vector<BaseFace> faces) {
  if (faces.empty()) return refusal("it has no faces");
  if (faces.size() > kMaxFaces)
    return refusal(std::to_string(faces.size()) + " faces; at most " + number(kMaxFaces) + " are supported");
  if (vertex_count > kMaxVertices)
    return refusal(number(vertex_count) + " vertices; at most " + number(kMaxVertices) + " are supported");
  BaseMesh mesh;
  mesh.faces_ = std::move(faces);
  if (Status s = mesh.readFaces(vertex_count); !s.ok()) return s.error();
  if (Status s = mesh.findTwins(); !s.ok()) return s.error();
  if (Status s = mesh.checkFans(); !s.ok()) return s.error();
  mesh.numberEdges();
  return mesh;
}

Status BaseMesh::readFaces(uint32_t vertex_count) {
  leaving_.assign(vertex_count, kNoHalfEdge);
  for (uint32_t f = 0; f < faceCount(); ++f) {
    const auto& [a, b, c] = faces_[f];
    for (uint32_t i = 0; i < 3; ++i) {
      const uint32_t v = faces_[f][i];
      if (v >= vertex_count)
        return refusal("face " + number(f) + " names vertex " + number(v) + "; there are " + number(vertex_count));
      leaving_[v] = 3 * f + i;
    }
    if (a == b || b == c || c == a) return refusal("face " + number(f) + " names a vertex twice");
  }
  for (uint32_t v = 0; v < vertex_count; ++v)
    if (leaving_[v] == kNoHalfEdge) return refusal("vertex " + number(v) + " belongs to no face");
  return {};
}

// Half-edges sorted by their ends: those of an edge stand together, the lowest first.
Status BaseMesh::findTwins() {
  const auto count = static_cast<HalfEdge>(3 * faces_.size());
  std::vector<std::pair<uint64_t, HalfEdge>> by_ends(count);
  for (HalfEdge h = 0; h < count; ++h) {
    const auto [low, high] = std::minmax({vertex(h), vertex(next(h))});
    by_ends[h] = {static_cast<uint64_t>(low) << 32 | high, h};
  }
  foreland::sort(by_ends.begin(), by_ends.end());
  twin_.assign(count, kNoHalfEdge);
  HalfEdge wrong = kNoHalfEdge, beside = kNoHalfEdge;  // the lowest that may not be where it is, and an earlier one
  for (size_t i = 1; i < count; ++i) {
    if (by_ends[i].first != by_ends[i - 1].first) continue;
    const HalfEdge one = by_ends[i - 1].second, other = by_ends[i].second;
    const bool fits = twin_[one] == kNoHalfEdge && vertex(one) != vertex(other);
    if (!fits && other < wrong) wrong = other, beside = one;
    twin_[one] = other;
    twin_[other] = one;
  }
  if (wrong == kNoHalfEdge) return {};
  const bool one_way = vertex(wrong) == vertex(beside);
  return refusal("edge (" + number(vertex(wrong)) + ", " + number(vertex(next(wrong))) + ") of face " +
                 number(face(wrong)) +
                 (one_way ? " runs the same way in face " + number(face(beside)) + "; turn one of them over"
                          : " has two faces already; split the surface there"));
}

// Around a vertex, from twin to twin, one must meet all its faces.
Status BaseMesh::checkFans() const {
  std::vector<uint32_t> faces_at(vertexCount(), 0);
  std::vector<HalfEdge> start = leaving_;
  for (HalfEdge h = 0; h < twin_.size(); ++h) {
    ++faces_at[vertex(h)];
    if (twin_[h] == kNoHalfEdge) start[vertex(h)] = h;
  }
  for (uint32_t v = 0; v < vertexCount(); ++v) {
    uint32_t met = 0;
    HalfEdge h = start[v];
    do {
      ++met;
      h = twin_[previous(h)];
    } while (h != kNoHalfEdge && h != start[v]);
    if (met != faces_at[v])
      return refusal("the faces of vertex " + number(v) +
                     " hang together in that point only; give each part a vertex of its own");
  }
  return {};
}

void BaseMesh::numberEdges() {
  edge_.resize(twin_.size());
  for (HalfEdge h = 0; h < twin_.size(); ++h) {
    if (twin_[h] == kNoHalfEdge || twin_[h] > h) {
      edge_[h] = static_cast<uint32_t>(first_.size());
      first_.push_back(h);
    } else {
      edge_[h] = edge_[twin_[h]];
    }
    if (twin_[h] == kNoHalfEdge) leaving_[vertex(h)] = h;
  }
}

}  // namespace foreland::proto
