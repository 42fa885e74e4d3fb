#include "terrain/remesh/original/original.h"

#include <algorithm>
#include <cmath>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <map>
#include <tuple>
#include <unordered_set>
#include <utility>

#include "terrain/remesh/original/cut_to_manifold.h"
#include "terrain/remesh/original/orientation.h"
#include "terrain/remesh/original/weld_and_triangulate.h"

namespace foreland::terrain {

namespace {

using glm::dvec3;

constexpr double kMinExtent =
    1e-9;  // of the diagonal of the bounding box; coordinates of smaller models are taken to be damaged

class OriginalMaker {
 public:
  OriginalMaker(const Model& model, OnDefect on_defect) : model_(model), repairs_(on_defect == OnDefect::kRepair) {}

  Result<Original> make() {
    for (const auto step :
         {&OriginalMaker::triangulate, &OriginalMaker::checkExtent, &OriginalMaker::checkDuplicateFaces,
          &OriginalMaker::connect, &OriginalMaker::orient, &OriginalMaker::splitFans})
      if (Status status = (this->*step)(); !status.ok())
        return Error{status.error().code, model_.name + ": " + status.error().message};
    return std::move(made_);
  }

 private:
  static Status refuse(std::string what) { return Error{ErrorCode::kMalformed, std::move(what)}; }
  std::string faceName(uint32_t triangle) const { return model_.faceName(made_.source_faces[triangle]); }
  std::string vertexName(uint32_t vertex) const { return model_.vertexName(made_.source_vertices[vertex]); }

  Status triangulate() { return weldAndTriangulate(model_, repairs_ ? OnDefect::kRepair : OnDefect::kRefuse, made_); }

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
    const auto is_same = [](const auto& a, const auto& b) { return a.first == b.first; };
    const auto twin = std::adjacent_find(sorted.begin(), sorted.end(), is_same);
    if (twin == sorted.end()) return {};
    if (repairs_) {
      std::vector<bool> repeats(made_.faces.size());
      for (size_t i = 1; i < sorted.size(); ++i) repeats[sorted[i].second] = is_same(sorted[i - 1], sorted[i]);
      return dropFaces(repeats), Status();
    }
    return refuse(faceName(std::next(twin)->second) + " has the same corners as " + faceName(twin->second) +
                  "; remove one of them");
  }

  void dropFaces(const std::vector<bool>& is_dropped) {
    uint32_t count = 0;
    for (uint32_t f = 0; f < is_dropped.size(); ++f) {
      if (is_dropped[f]) continue;
      made_.faces[count] = made_.faces[f], made_.source_faces[count] = made_.source_faces[f];
      made_.source_corners[count++] = made_.source_corners[f];
    }
    made_.repairs.duplicate_faces += made_.faces.size() - count;
    made_.faces.resize(count), made_.source_faces.resize(count), made_.source_corners.resize(count);
  }

  Status connect() {
    Adjacency adjacency = findAdjacency(made_.faces);
    made_.twins = std::move(adjacency.twins);
    if (repairs_) return cut(), Status();
    if (adjacency.non_manifold_face == kNoIndex) return {};
    const Triangle& t = made_.faces[adjacency.non_manifold_face];
    const uint32_t a = t[adjacency.non_manifold_edge], b = t[(adjacency.non_manifold_edge + 1) % 3];
    return refuse(faceName(adjacency.non_manifold_face) + " shares its edge from " + vertexName(a) + " to " +
                  vertexName(b) +
                  " with more than one other face; a surface has at most two faces at an edge, so separate the sheets");
  }
  void cut() {
    std::vector<Triangle> sources = made_.faces;
    for (uint32_t c = 0; c < 3 * sources.size(); ++c) sources[c / 3][c % 3] = sourceVertex(c);
    ManifoldTwins found = cutToManifold(made_.faces, sources);
    made_.twins = std::move(found.twins);
    made_.repairs.cut_edges = found.cut_edges;
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
    if (made_.flipped > 0) turnTwins(found.is_flipped);
    return {};
  }
  // Edge k of a face that was flipped is edge 2 - k now.
  void turnTwins(const std::vector<bool>& is_flipped) {
    for (uint32_t f = 0; f < made_.faces.size(); ++f) {
      if (is_flipped[f]) std::swap(made_.twins[f][0], made_.twins[f][2]);
      for (uint32_t& twin : made_.twins[f])
        if (twin != kNoIndex && is_flipped[twin / 3]) twin = twin - twin % 3 + 2 - twin % 3;
    }
  }

  // The faces at a vertex must form one fan. Fans that only welding has brought together get vertices of their own
  // again.
  Status splitFans() {
    std::vector<bool> is_seen(3 * made_.faces.size());
    std::vector<uint32_t> first(made_.positions.size(), kNoIndex);  // a corner of each vertex's first fan
    std::map<uint32_t, std::unordered_set<uint32_t>> joined;  // the model's vertices in the fans so far, if several
    std::vector<uint32_t> fan;
    for (uint32_t c = 0; c < is_seen.size(); ++c) {
      if (is_seen[c]) continue;
      const uint32_t v = cornerVertex(c);
      if (first[v] != kNoIndex && !joined.contains(v)) {
        gatherFan(first[v], fan);
        for (uint32_t corner : fan) joined[v].insert(sourceVertex(corner));
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

  // Gives `fan` a vertex of its own. If the model itself has it share a vertex with an earlier fan, that is an error or
  // a repair.
  Status splitOff(uint32_t v, const std::vector<uint32_t>& fan, std::unordered_set<uint32_t>& others) {
    const bool is_shared =
        std::any_of(fan.begin(), fan.end(), [&](uint32_t c) { return others.contains(sourceVertex(c)); });
    for (uint32_t c : fan) others.insert(sourceVertex(c));
    if (is_shared && !repairs_)
      return refuse(vertexName(v) + " joins parts of the surface that touch in this point only; give each its own");
    const auto own = static_cast<uint32_t>(made_.positions.size());
    for (uint32_t c : fan) cornerVertex(c) = own;
    made_.positions.push_back(made_.positions[v]);
    made_.source_vertices.push_back(sourceVertex(fan.front()));
    if (is_shared)
      ++made_.repairs.split_vertices;
    else
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
  bool repairs_;
  Original made_;
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

Result<Original> makeOriginal(const Model& model, OnDefect on_defect) { return OriginalMaker(model, on_defect).make(); }

std::vector<Triangle> facesAsGiven(const Original& original) {
  std::vector<Triangle> faces = original.faces;
  for (size_t f = 0; f < faces.size(); ++f) {
    const auto& c = original.source_corners[f];  // ascending around the model's face, from any of the three
    const int descents = (c[0] > c[1]) + (c[1] > c[2]) + (c[2] > c[0]);
    if (descents == 2) std::swap(faces[f][1], faces[f][2]);
  }
  return faces;
}

Result<std::vector<glm::dvec3>> positionsInPose(const Original& original, const Model& model, const Model& pose) {
  const auto refuse = [&](const std::string& what) {
    return Error{ErrorCode::kInvalidArgument, pose.name + " is no pose of " + model.name + ": " + what};
  };
  if (pose.positions.size() != model.positions.size() || pose.face_ends != model.face_ends)
    return refuse("it has " + std::to_string(pose.positions.size()) + " vertices and " +
                  std::to_string(pose.faceCount()) + " faces, not " + std::to_string(model.positions.size()) + " and " +
                  std::to_string(model.faceCount()) + ", or faces of other sizes");
  for (size_t face = 0; face < model.faceCount(); ++face)
    for (uint64_t c = model.faceBegin(face); c < model.face_ends[face]; ++c)
      if (pose.corners[c].vertex != model.corners[c].vertex) return refuse(pose.faceName(face) + " has other vertices");
  std::vector<glm::dvec3> positions;
  for (uint32_t source : original.source_vertices) positions.push_back(pose.positions[source]);
  for (size_t face = 0; face < original.faces.size(); ++face)
    for (size_t k = 0; k < 3; ++k) {
      const uint32_t source = model.corners[original.source_corners[face][k]].vertex;
      if (pose.positions[source] != positions[original.faces[face][k]])
        return refuse(pose.vertexName(source) + " has left one that it lies on in " + model.name);
    }
  return positions;
}

}  // namespace foreland::terrain
