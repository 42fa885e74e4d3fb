#include "terrain/remesh/original/original.h"

#include <algorithm>
#include <cmath>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <map>
#include <numeric>
#include <tuple>
#include <unordered_set>
#include <utility>

#include "terrain/remesh/original/orientation.h"
#include "terrain/remesh/original/triangulate.h"

namespace foreland::terrain {

namespace {

using glm::dvec3;

constexpr double kMinExtent =
    1e-9;  // of the diagonal of the bounding box; coordinates of smaller models are taken to be damaged

class OriginalMaker {
 public:
  explicit OriginalMaker(const Model& model) : model_(model) {}

  Result<Original> make() {
    weld();
    for (const auto step :
         {&OriginalMaker::triangulateFaces, &OriginalMaker::checkExtent, &OriginalMaker::checkDuplicateFaces,
          &OriginalMaker::connect, &OriginalMaker::orient, &OriginalMaker::splitFans})
      if (Status status = (this->*step)(); !status.ok())
        return Error{status.error().code, model_.name + ": " + status.error().message};
    return std::move(made_);
  }

 private:
  static Status refuse(std::string what) { return Error{ErrorCode::kMalformed, std::move(what)}; }
  std::string faceName(uint32_t triangle) const { return model_.faceName(made_.source_faces[triangle]); }
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
    std::vector<dvec3> outline;
    std::unordered_set<uint64_t> edges = outlines();
    for (uint32_t face = 0; face < model_.faceCount(); ++face) {
      const uint64_t begin = model_.faceBegin(face);
      if (Status status = checkOutline(face); !status.ok()) return status;
      outline.clear();
      for (uint64_t c = begin; c < model_.face_ends[face]; ++c)
        outline.push_back(model_.positions[model_.corners[c].vertex]);
      const auto key = [&](uint32_t i, uint32_t j) { return keyOf(vertexAt(begin + i), vertexAt(begin + j)); };
      const auto triangles = triangulate(outline, [&](uint32_t i, uint32_t j) { return !edges.contains(key(i, j)); });
      if (triangles.empty())
        return refuse(model_.faceName(face) + " has no area or crosses itself; remove or correct it");
      for (const auto& t : triangles) {
        made_.faces.push_back({vertexAt(begin + t[0]), vertexAt(begin + t[1]), vertexAt(begin + t[2])});
        made_.source_corners.push_back({begin + t[0], begin + t[1], begin + t[2]});
        made_.source_faces.push_back(face);
        if (triangles.size() > 1)
          for (uint32_t k = 0; k < 3; ++k) edges.insert(key(t[k], t[(k + 1) % 3]));
      }
    }
    if (made_.faces.size() > kMaxModelVertices)
      return Error{ErrorCode::kLimit, "more than 134217728 triangles; simplify the model"};
    return {};
  }
  uint32_t vertexAt(uint64_t corner) const { return vertices_[model_.corners[corner].vertex]; }

  Status checkOutline(uint32_t face) {
    corners_.clear();
    for (uint64_t c = model_.faceBegin(face); c < model_.face_ends[face]; ++c) corners_.push_back(vertexAt(c));
    std::sort(corners_.begin(), corners_.end());
    const auto twice = std::adjacent_find(corners_.begin(), corners_.end());
    if (twice == corners_.end()) return {};
    return refuse(model_.faceName(face) + " has two corners at the position of " + vertexName(*twice) +
                  "; remove or correct it");
  }

  Status checkExtent() {
    dvec3 low = made_.positions.front(), high = low;
    for (const dvec3& p : made_.positions) low = glm::min(low, p), high = glm::max(high, p);
    if (glm::length(high - low) < kMinExtent) return refuse("is smaller than 1e-9; scale the model up");
    return {};
  }

  // Two faces on the same three vertices.
  Status checkDuplicateFaces() {
    std::vector<std::pair<Triangle, uint32_t>> sorted;
    sorted.reserve(made_.faces.size());
    for (uint32_t f = 0; f < made_.faces.size(); ++f) {
      Triangle t = made_.faces[f];
      std::sort(t.begin(), t.end());
      sorted.emplace_back(t, f);
    }
    std::sort(sorted.begin(), sorted.end());
    const auto twin = std::adjacent_find(sorted.begin(), sorted.end(),
                                         [](const auto& a, const auto& b) { return a.first == b.first; });
    if (twin == sorted.end()) return {};
    return refuse(faceName(std::next(twin)->second) + " has the same corners as " + faceName(twin->second) +
                  "; remove one of them");
  }

  Status connect() {
    Adjacency adjacency = findAdjacency(made_.faces);
    made_.twins = std::move(adjacency.twins);
    if (adjacency.non_manifold_face == kNoIndex) return {};
    const Triangle& t = made_.faces[adjacency.non_manifold_face];
    const uint32_t a = t[adjacency.non_manifold_edge], b = t[(adjacency.non_manifold_edge + 1) % 3];
    return refuse(faceName(adjacency.non_manifold_face) + " shares its edge from " + vertexName(a) + " to " +
                  vertexName(b) +
                  " with more than one other face; a surface has at most two faces at an edge, so separate the sheets");
  }

  Status orient() {
    const Orientation found = findOrientation(made_.positions, made_.faces, made_.twins);
    if (found.non_orientable_face != kNoIndex)
      return refuse(faceName(found.non_orientable_face) +
                    " closes a surface with one side only, as a Moebius strip is; cut it there");
    uint32_t last = kNoIndex;
    for (uint32_t f = 0; f < made_.faces.size(); ++f) {
      if (!found.is_flipped[f]) continue;
      std::swap(made_.faces[f][1], made_.faces[f][2]);
      std::swap(made_.source_corners[f][1], made_.source_corners[f][2]);
      made_.flipped += made_.source_faces[f] != last;
      last = made_.source_faces[f];
    }
    if (made_.flipped > 0) made_.twins = findAdjacency(made_.faces).twins;
    return {};
  }

  // The faces at a vertex must form one fan. Fans that only welding has brought together get vertices of their own
  // again.
  Status splitFans() {
    std::vector<bool> is_seen(3 * made_.faces.size());
    std::vector<uint32_t> first(made_.positions.size(), kNoIndex);  // a corner of each vertex's first fan
    std::map<uint32_t, std::vector<uint32_t>> joined;  // the model's vertices in the fans so far, if several
    std::vector<uint32_t> fan;
    for (uint32_t c = 0; c < is_seen.size(); ++c) {
      if (is_seen[c]) continue;
      const uint32_t v = cornerVertex(c);
      if (first[v] != kNoIndex && !joined.contains(v)) {
        gatherFan(first[v], fan);
        for (uint32_t corner : fan) joined[v].push_back(sourceVertex(corner));
      }
      gatherFan(c, fan);
      for (uint32_t corner : fan) is_seen[corner] = true;
      if (first[v] == kNoIndex)
        first[v] = c;
      else if (Status status = splitOff(v, fan, joined[v]); !status.ok())
        return status;
    }
    return {};
  }
  uint32_t& cornerVertex(uint32_t c) { return made_.faces[c / 3][c % 3]; }
  uint32_t sourceVertex(uint32_t c) const { return model_.corners[made_.source_corners[c / 3][c % 3]].vertex; }

  // Gives `fan` a vertex of its own. Error if the model itself has it share a vertex with an earlier fan.
  Status splitOff(uint32_t v, const std::vector<uint32_t>& fan, std::vector<uint32_t>& others) {
    const size_t before = others.size();
    for (uint32_t c : fan) {
      const uint32_t source = sourceVertex(c);
      if (std::find(others.begin(), others.begin() + static_cast<ptrdiff_t>(before), source) !=
          others.begin() + static_cast<ptrdiff_t>(before))
        return refuse(vertexName(v) + " joins parts of the surface that touch in this point only; give each its own");
      others.push_back(source);
    }
    const auto own = static_cast<uint32_t>(made_.positions.size());
    for (uint32_t c : fan) cornerVertex(c) = own;
    made_.positions.push_back(made_.positions[v]);
    made_.source_vertices.push_back(sourceVertex(fan.front()));
    --made_.welded;
    return {};
  }

  // All corners around the vertex of `corner`, as far as faces are connected by edges there.
  void gatherFan(uint32_t corner, std::vector<uint32_t>& fan) const {
    const auto left = [&](uint32_t c) { return made_.twins[c / 3][(c % 3 + 2) % 3]; };
    const auto right = [&](uint32_t c) {
      const uint32_t twin = made_.twins[c / 3][c % 3];
      return twin == kNoIndex ? kNoIndex : twin - twin % 3 + (twin % 3 + 1) % 3;
    };
    fan.assign(1, corner);
    uint32_t at = left(corner);
    for (; at != kNoIndex && at != corner; at = left(at)) fan.push_back(at);
    if (at == corner) return;
    for (at = right(corner); at != kNoIndex; at = right(at)) fan.push_back(at);
  }

  const Model& model_;
  Original made_;
  std::vector<uint32_t> vertices_;  // of the model's vertices; kNoIndex for those that no face uses
  std::vector<uint32_t> corners_;   // scratch
};

}  // namespace

Adjacency findAdjacency(const std::vector<Triangle>& faces) {
  struct Side {
    uint32_t low, high, at;  // at: 3 * face + edge
    bool operator<(const Side& other) const {
      return std::tie(low, high, at) < std::tie(other.low, other.high, other.at);
    }
  };
  std::vector<Side> sides;
  sides.reserve(3 * faces.size());
  for (uint32_t f = 0; f < faces.size(); ++f)
    for (uint32_t k = 0; k < 3; ++k) {
      const auto [low, high] = std::minmax(faces[f][k], faces[f][(k + 1) % 3]);
      sides.push_back({low, high, 3 * f + k});
    }
  std::sort(sides.begin(), sides.end());
  Adjacency found;
  found.twins.assign(faces.size(), {kNoIndex, kNoIndex, kNoIndex});
  for (size_t i = 0, end = 0; i < sides.size(); i = end) {
    for (end = i + 1; end < sides.size() && sides[end].low == sides[i].low && sides[end].high == sides[i].high;) ++end;
    if (end - i > 2) {
      if (sides[i + 2].at / 3 < found.non_manifold_face)
        found.non_manifold_face = sides[i + 2].at / 3, found.non_manifold_edge = sides[i + 2].at % 3;
    } else if (end - i == 2) {
      found.twins[sides[i].at / 3][sides[i].at % 3] = sides[i + 1].at;
      found.twins[sides[i + 1].at / 3][sides[i + 1].at % 3] = sides[i].at;
    }
  }
  return found;
}

Result<Original> makeOriginal(const Model& model) { return OriginalMaker(model).make(); }

}  // namespace foreland::terrain
