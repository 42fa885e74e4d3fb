#include "oracle/crack_checker.h"

#include <algorithm>
#include <cmath>
#include <span>
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
    if (shape_.is_cube)
      checkSphere();
    else
      checkAreas();
    checkEdges();
    return report_;
  }

 private:
  // Of one triangle, at the lower of the two vertices, which are merged by lattice position.
  struct Edge {
    uint32_t high;  // the other
    bool runs_up;   // to `high` in its triangle
    bool operator<(const Edge& o) const { return std::tie(high, runs_up) < std::tie(o.high, o.runs_up); }
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
    struct Place {
      float y, x;
      uint32_t vertex;
      bool operator<(const Place& o) const { return std::tie(y, x, vertex) < std::tie(o.y, o.x, o.vertex); }
    };
    std::vector<bool> is_used(mesh_.parameters.size());  // not the places of vertices that no triangle uses
    for (const uint32_t i : mesh_.indices) is_used[i] = true;
    std::vector<Place> places;
    for (uint32_t i = 0; i < is_used.size(); ++i)
      if (is_used[i]) places.push_back({mesh_.parameters[i].y, mesh_.parameters[i].x, i});
    std::sort(places.begin(), places.end());
    name_.resize(mesh_.parameters.size());
    for (size_t k = 0; k < places.size(); ++k) {
      const uint32_t i = places[k].vertex;
      const bool is_again = k > 0 && places[k - 1].y == places[k].y && places[k - 1].x == places[k].x;
      name_[i] = is_again ? name_[places[k - 1].vertex] : i;
      if (!isSamePosition(i, name_[i])) found("two vertices at " + text(mesh_.parameters[i]) + " are apart");
    }
  }

  bool isSamePosition(uint32_t i, uint32_t j) const {
    return mesh_.from_positions[i] == mesh_.from_positions[j] && mesh_.to_positions[i] == mesh_.to_positions[j] &&
           (mesh_.from_bends.empty() ||
            (mesh_.from_bends[i] == mesh_.from_bends[j] && mesh_.to_bends[i] == mesh_.to_bends[j]));
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

  // Of a globe, whose triangles have no area in one lattice: closed, as checkEdges() sees, and with as many vertices as
  // a sphere, so without a hole or a second sheet.
  void checkSphere() {
    std::vector<uint32_t> used;
    for (const uint32_t i : mesh_.indices) used.push_back(name_[i]);
    std::sort(used.begin(), used.end());
    const auto vertices = static_cast<size_t>(std::unique(used.begin(), used.end()) - used.begin());
    if (mesh_.triangleCount() + 4 != 2 * vertices)
      found(std::to_string(mesh_.triangleCount()) + " triangles have " + std::to_string(vertices) +
            " vertices: no sphere");
  }

  bool isOnBorder(uint32_t low, uint32_t high) const {
    if (shape_.is_cube) return false;
    const glm::vec2 a = mesh_.parameters[low], b = mesh_.parameters[high];
    const float max_x = static_cast<float>(shape_.samples_x - 1), max_y = static_cast<float>(shape_.samples_y - 1);
    return (a.x == b.x && (a.x == 0 || a.x == max_x)) || (a.y == b.y && (a.y == 0 || a.y == max_y));
  }

  // Sorts the edges by vertex first: a few meet at each.
  void checkEdges() {
    const auto visit = [&](auto&& use) {
      for (size_t i = 0; i < mesh_.indices.size(); ++i) {
        const uint32_t a = name_[mesh_.indices[i]], b = name_[mesh_.indices[i % 3 == 2 ? i - 2 : i + 1]];
        use(std::min(a, b), Edge{std::max(a, b), a < b});
      }
    };
    std::vector<size_t> first(name_.size() + 2);  // by vertex
    visit([&](uint32_t low, Edge) { ++first[low + 2]; });
    for (size_t v = 2; v < first.size(); ++v) first[v] += first[v - 1];
    std::vector<Edge> edges(mesh_.indices.size());
    visit([&](uint32_t low, Edge e) { edges[first[low + 1]++] = e; });
    for (uint32_t v = 0; v < name_.size(); ++v)
      checkEdgesAt(v, std::span(edges).subspan(first[v], first[v + 1] - first[v]));
  }

  void checkEdgesAt(uint32_t low, std::span<Edge> edges) {
    std::sort(edges.begin(), edges.end());
    for (size_t i = 0; i < edges.size();) {
      size_t end = i + 1;
      while (end < edges.size() && edges[end].high == edges[i].high) ++end;
      checkLine(low, edges.subspan(i, end - i));
      i = end;
    }
  }

  // All triangles' edges between two vertices.
  void checkLine(uint32_t low, std::span<const Edge> edges) {
    const bool on_border = isOnBorder(low, edges[0].high);
    const bool is_opposed_pair = edges.size() == 2 && edges[0].runs_up != edges[1].runs_up;
    if (on_border ? edges.size() == 1 : is_opposed_pair) return;
    found("edge " + text(mesh_.parameters[low]) + " to " + text(mesh_.parameters[edges[0].high]) +
          (on_border ? " on the border" : "") + " has " + std::to_string(edges.size()) + " triangles" +
          (edges.size() == 2 ? ", on one side" : ""));
  }

  const KeyframeMesh& mesh_;
  const proto::GridShape& shape_;
  std::vector<uint32_t> name_;
  CrackReport report_;
};

}  // namespace

CrackReport findCracks(const KeyframeMesh& mesh, const proto::GridShape& shape) { return Checker(mesh, shape).run(); }

}  // namespace foreland::oracle
