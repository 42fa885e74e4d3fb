#include "oracle/crack_checker.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <tuple>
#include <vector>

namespace foreland::oracle {

namespace {

using client::KeyframeMesh;

std::string text(glm::vec2 p) { return "(" + std::to_string(p.x) + ", " + std::to_string(p.y) + ")"; }

class Checker {
 public:
  Checker(const KeyframeMesh& mesh, const proto::GridShape& shape) : mesh_(mesh), shape_(shape) {}

  CrackReport run() {
    if (!checkSizes()) return report_;
    mergeVertices();
    checkAreas();
    checkEdges();
    return report_;
  }

 private:
  struct Edge {
    uint32_t low, high;  // vertices, merged by lattice position
    bool runs_up;        // from low to high in its triangle
    bool operator<(const Edge& o) const { return std::tie(low, high, runs_up) < std::tie(o.low, o.high, o.runs_up); }
    bool isSameLine(const Edge& o) const { return low == o.low && high == o.high; }
  };

  void found(const std::string& what) {
    if (report_.cracks++ == 0) report_.first = what;
  }

  bool checkSizes() {
    const size_t n = mesh_.parameters.size();
    if (mesh_.from_positions.size() != n || mesh_.to_positions.size() != n ||
        mesh_.from_bends.size() != mesh_.to_bends.size() || (!mesh_.from_bends.empty() && mesh_.from_bends.size() != n))
      found("positions and places differ in number");
    if (mesh_.indices.size() % 3 != 0) found("indices are not a multiple of three");
    if (std::ranges::any_of(mesh_.indices, [n](uint32_t i) { return i >= n; }))
      found("an index points past the vertices");
    return report_.cracks == 0;
  }

  // Gives vertices at one lattice position one name, and compares their positions.
  void mergeVertices() {
    std::vector<uint32_t> order = mesh_.indices;  // not the places of vertices that no triangle uses
    std::ranges::sort(order);
    order.erase(std::unique(order.begin(), order.end()), order.end());
    const auto key = [this](uint32_t i) { return std::pair(mesh_.parameters[i].y, mesh_.parameters[i].x); };
    std::ranges::sort(order, {}, key);
    name_.resize(mesh_.parameters.size());
    for (size_t k = 0; k < order.size(); ++k) {
      const uint32_t i = order[k];
      name_[i] = k > 0 && key(order[k - 1]) == key(i) ? name_[order[k - 1]] : i;
      if (mesh_.from_positions[i] != mesh_.from_positions[name_[i]] ||
          mesh_.to_positions[i] != mesh_.to_positions[name_[i]] ||
          (!mesh_.from_bends.empty() &&
           (mesh_.from_bends[i] != mesh_.from_bends[name_[i]] || mesh_.to_bends[i] != mesh_.to_bends[name_[i]])))
        found("two vertices at " + text(mesh_.parameters[i]) + " are apart");
    }
  }

  void checkAreas() {
    double twice_total = 0;
    for (size_t t = 0; t < mesh_.triangleCount(); ++t) {
      const glm::dvec2 a(mesh_.parameters[mesh_.indices[3 * t]]), b(mesh_.parameters[mesh_.indices[3 * t + 1]]),
          c(mesh_.parameters[mesh_.indices[3 * t + 2]]);
      const double twice_area = (b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x);
      if (!(twice_area > 0))
        found("triangle " + std::to_string(t) + " at " + text(mesh_.parameters[mesh_.indices[3 * t]]) +
              " has no area or is flipped");
      twice_total += twice_area;
    }
    const double twice_data = 2.0 * (shape_.samples_x - 1) * (shape_.samples_y - 1);
    // Areas are multiples of 1/2 and add up exactly in doubles below 2^52.
    if (twice_total != twice_data)
      found("triangles cover " + std::to_string(twice_total / 2) + " cells, the data has " +
            std::to_string(twice_data / 2));
  }

  bool isOnBorder(const Edge& e) const {
    const glm::vec2 a = mesh_.parameters[e.low], b = mesh_.parameters[e.high];
    const float max_x = static_cast<float>(shape_.samples_x - 1), max_y = static_cast<float>(shape_.samples_y - 1);
    return (a.x == b.x && (a.x == 0 || a.x == max_x)) || (a.y == b.y && (a.y == 0 || a.y == max_y));
  }

  void checkEdges() {
    std::vector<Edge> edges;
    edges.reserve(mesh_.indices.size());
    for (size_t i = 0; i < mesh_.indices.size(); ++i) {
      const uint32_t a = name_[mesh_.indices[i]], b = name_[mesh_.indices[i % 3 == 2 ? i - 2 : i + 1]];
      edges.push_back({std::min(a, b), std::max(a, b), a < b});
    }
    std::ranges::sort(edges, std::less<>{});
    for (size_t i = 0; i < edges.size();) {
      size_t end = i + 1;
      while (end < edges.size() && edges[end].isSameLine(edges[i])) ++end;
      checkLine(edges[i], end - i, end - i == 2 && edges[i].runs_up != edges[i + 1].runs_up);
      i = end;
    }
  }

  void checkLine(const Edge& e, size_t triangles, bool is_opposed_pair) {
    const bool on_border = isOnBorder(e);
    if (on_border ? triangles == 1 : is_opposed_pair) return;
    found("edge " + text(mesh_.parameters[e.low]) + " to " + text(mesh_.parameters[e.high]) +
          (on_border ? " on the border" : "") + " has " + std::to_string(triangles) + " triangles" +
          (triangles == 2 ? ", on one side" : ""));
  }

  const KeyframeMesh& mesh_;
  const proto::GridShape& shape_;
  std::vector<uint32_t> name_;
  CrackReport report_;
};

}  // namespace

CrackReport findCracks(const KeyframeMesh& mesh, const proto::GridShape& shape) { return Checker(mesh, shape).run(); }

}  // namespace foreland::oracle
