#include "oracle/surface/object_cracks.h"

#include <algorithm>
#include <map>
#include <tuple>

namespace foreland::oracle {

namespace {

// What a vertex is called whichever face it was met in: a base vertex (itself, itself, 0), a point of a base edge (its
// ends, the weight of the second), or a point inside a face (kInside + face, two weights).
using Name = std::array<int64_t, 3>;
constexpr int64_t kInside = int64_t{1} << 40;

struct ObjectCorner {
  SurfacePoint point;
  Name name;
};

std::string text(const SurfacePoint& p) {
  return "(face " + std::to_string(p.face) + ", weights " + std::to_string(p.weights[0]) + ", " +
         std::to_string(p.weights[1]) + ")";
}

class ObjectChecker {
 public:
  ObjectChecker(const client::BlendMesh& mesh, const client::ObjectPart& part, const ModelTruth& model)
      : mesh_(mesh), part_(part), model_(model), twice_area_(model.faces.size(), 0) {
    for (const auto& face : model.faces)
      for (size_t i = 0; i < 3; ++i) ++faces_of_edge_[std::minmax(face[i], face[(i + 1) % 3])];
  }

  CrackReport run() {
    if (part_.index_count % 3 != 0 || size_t{part_.first_index} + part_.index_count > mesh_.indices.size()) {
      found("its indices are no triangles of the mesh");
      return report_;
    }
    for (uint32_t i = 0; i < part_.index_count; i += 3) addTriangle(part_.first_index + i);
    checkAreas();
    checkEdges();
    return report_;
  }

 private:
  void found(const std::string& what) {
    if (report_.cracks++ == 0) report_.first = what;
  }

  std::array<int32_t, 3> weightsOf(const SurfacePoint& p) const {
    return {model_.weight_sum - p.weights[0] - p.weights[1], p.weights[0], p.weights[1]};
  }

  Name nameOf(const SurfacePoint& p) const {
    const auto weights = weightsOf(p);
    const auto& corners = model_.faces[p.face];
    for (size_t i = 0; i < 3; ++i)
      if (weights[i] == model_.weight_sum) return {corners[i], corners[i], 0};
    for (size_t i = 0; i < 3; ++i) {
      const size_t j = (i + 1) % 3, k = (i + 2) % 3;
      if (weights[i] != 0) continue;
      return corners[j] < corners[k] ? Name{corners[j], corners[k], weights[k]}
                                     : Name{corners[k], corners[j], weights[j]};
    }
    return {kInside + p.face, p.weights[0], p.weights[1]};
  }

  bool cornerAt(uint32_t index, ObjectCorner& out) {
    const uint32_t v = mesh_.indices[index];
    const auto point = v < mesh_.parameters.size() ? pointAt(model_, mesh_.parameters[v]) : std::nullopt;
    if (!point || point->face >= model_.faces.size()) {
      found("vertex " + std::to_string(v) + " is no point of the surface");
      return false;
    }
    out = {*point, nameOf(*point)};
    const uint32_t first = vertices_.try_emplace(out.name, v).first->second;
    if (mesh_.from_positions[v] != mesh_.from_positions[first] || mesh_.to_positions[v] != mesh_.to_positions[first])
      found("two vertices at " + text(*point) + " are apart");
    return true;
  }

  void addTriangle(uint32_t index) {
    std::array<ObjectCorner, 3> c;
    for (uint32_t k = 0; k < 3; ++k)
      if (!cornerAt(index + k, c[k])) return;
    if (c[0].point.face != c[1].point.face || c[0].point.face != c[2].point.face) {
      found("a triangle at " + text(c[0].point) + " reaches into another base face");
      return;
    }
    const auto& [a, b, d] = std::tie(c[0].point.weights, c[1].point.weights, c[2].point.weights);
    const int64_t twice_area = int64_t{b[0] - a[0]} * (d[1] - a[1]) - int64_t{b[1] - a[1]} * (d[0] - a[0]);
    if (twice_area <= 0) found("a triangle at " + text(c[0].point) + " has no area or is flipped");
    twice_area_[c[0].point.face] += twice_area;
    for (size_t k = 0; k < 3; ++k) addEdge(c[k], c[(k + 1) % 3]);
  }

  void addEdge(const ObjectCorner& a, const ObjectCorner& b) {
    Edge& edge = edges_[std::minmax(a.name, b.name)];
    ++(a.name < b.name ? edge.up : edge.down);
    edge.at = a.point;
    edge.is_border = isOnBorder(a.point, b.point);
  }

  // Whether both points lie on one base edge that only this face has.
  bool isOnBorder(const SurfacePoint& a, const SurfacePoint& b) const {
    const auto from = weightsOf(a), to = weightsOf(b);
    const auto& corners = model_.faces[a.face];
    for (size_t i = 0; i < 3; ++i)
      if (from[i] == 0 && to[i] == 0)
        return faces_of_edge_.at(std::minmax(corners[(i + 1) % 3], corners[(i + 2) % 3])) == 1;
    return false;
  }

  void checkAreas() {
    const int64_t whole = int64_t{model_.weight_sum} * model_.weight_sum;
    for (size_t face = 0; face < twice_area_.size(); ++face)
      if (twice_area_[face] != whole)
        found("triangles cover " + std::to_string(static_cast<double>(twice_area_[face]) / static_cast<double>(whole)) +
              " of base face " + std::to_string(face));
  }

  void checkEdges() {
    for (const auto& [names, edge] : edges_) {
      if (edge.is_border ? edge.up + edge.down == 1 : edge.up == 1 && edge.down == 1) continue;
      found("an edge at " + text(edge.at) + (edge.is_border ? " on the border" : "") + " has " +
            std::to_string(edge.up) + " and " + std::to_string(edge.down) + " triangles on its sides");
    }
  }

  struct Edge {
    uint32_t up = 0, down = 0;  // triangles that run along it in either direction
    bool is_border = false;
    SurfacePoint at;
  };

  const client::BlendMesh& mesh_;
  const client::ObjectPart& part_;
  const ModelTruth& model_;
  std::map<std::pair<uint32_t, uint32_t>, int> faces_of_edge_;
  std::vector<int64_t> twice_area_;  // by base face
  std::map<Name, uint32_t> vertices_;
  std::map<std::pair<Name, Name>, Edge> edges_;
  CrackReport report_;
};

}  // namespace

CrackReport findObjectCracks(const client::BlendMesh& mesh, const client::ObjectPart& part, const ModelTruth& model) {
  return ObjectChecker(mesh, part, model).run();
}

}  // namespace foreland::oracle
