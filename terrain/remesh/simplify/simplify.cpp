#include "terrain/remesh/simplify/simplify.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/geometric.hpp>
#include <map>
#include <queue>
#include <tuple>
#include <utility>

#include "terrain/remesh/original/triangulate.h"
#include "terrain/remesh/simplify/one_ring.h"
#include "terrain/remesh/simplify/quadric.h"

namespace foreland::terrain {

namespace {

using glm::dvec3;

// What a step may do to the shape of triangles. Tried one after the other, until the target is reached.
struct Limits {
  double least_quality;  // of triangles, laid out and in space, unless they were worse before
  double least_cosine;   // between a face's normal before and after
  size_t most_neighbours;
};
constexpr std::array<Limits, 3> kLimits{{{0.2, 0.3, 9}, {0.05, 0.0, 12}, {0.005, -0.5, 24}}};

constexpr double kBorderWeight = 10, kCreaseWeight = 3;  // of their planes, against those of faces
constexpr double kLengthWeight = 3e-3;  // of squared lengths against squared distances: even triangles where it is flat

constexpr double kSliver = 0.02;  // quality below which a triangle is one

struct Removal {
  double cost = 0;
  uint32_t vertex = 0, version = 0;
  size_t kept = 0;                              // index into the ring
  bool operator<(const Removal& other) const {  // the queue gives the largest first
    return std::tie(other.cost, other.vertex) < std::tie(cost, vertex);
  }
};

class Simplifier {
 public:
  Simplifier(const Original& original, const SimplifyOptions& options)
      : original_(original),
        options_(options),
        positions_(original.positions),
        faces_(original.faces),
        is_alive_(faces_.size(), true),
        alive_(static_cast<uint32_t>(faces_.size())),
        faces_at_(positions_.size()),
        quadrics_(positions_.size()),
        along_(positions_.size()),
        versions_(positions_.size()),
        map_(faces_.size()) {
    for (uint32_t f = 0; f < faces_.size(); ++f)
      for (uint32_t v : faces_[f]) faces_at_[v].push_back(f);
    for (dvec3& p : positions_) p -= original.positions.front();
    measure();
  }

  Base run() {
    for (const Limits& limits : kLimits) {
      limits_ = limits;
      queue_ = {};
      for (uint32_t v = 0; v < positions_.size(); ++v) enqueue(v);
      while (alive_ > options_.target_faces && !queue_.empty()) {
        const Removal removal = queue_.top();
        queue_.pop();
        if (removal.version == versions_[removal.vertex]) tryRemoval(removal);
      }
      if (alive_ <= options_.target_faces) break;
    }
    return finish();
  }

 private:
  // Quadrics of faces, borders and creases.
  void measure() {
    for (uint32_t f = 0; f < faces_.size(); ++f) {
      const Triangle& t = faces_[f];
      const dvec3 area = glm::cross(positions_[t[1]] - positions_[t[0]], positions_[t[2]] - positions_[t[0]]);
      const dvec3 normal = glm::normalize(area);
      for (uint32_t v : t) quadrics_[v].addPlane(normal, positions_[v], importanceOf(f) * glm::length(area) / 6);
      for (uint32_t k = 0; k < 3; ++k) measureEdge(f, k, normal);
    }
  }
  void measureEdge(uint32_t f, uint32_t k, const dvec3& normal) {
    const uint32_t a = faces_[f][k], b = faces_[f][(k + 1) % 3], beyond = original_.across[f][k];
    const bool is_border = beyond == kNoIndex;
    if (!is_border && glm::dot(normal, normalOf(faces_[beyond / 3], positions_)) >= options_.crease_cosine) return;
    const dvec3 edge = positions_[b] - positions_[a];
    const double weight = importanceOf(f) * (is_border ? kBorderWeight : kCreaseWeight) * glm::dot(edge, edge);
    const dvec3 wall = glm::normalize(glm::cross(edge, normal));
    for (uint32_t v : {a, b}) quadrics_[v].addPlane(wall, positions_[v], weight);
    if (is_border || f < beyond / 3) {
      along_[a].push_back(b), along_[b].push_back(a);
      courses_[std::minmax(a, b)] = {{}, {3 * f + k}};
    }
  }

  double importanceOf(uint32_t f) const {
    if (options_.importance.empty()) return 1;
    double sum = 0;
    for (uint32_t v : faces_[f]) sum += options_.importance[v] / 3;
    return sum;
  }

  // --- which vertex goes, and where to

  void enqueue(uint32_t v) {
    const uint32_t version = ++versions_[v];
    if (faces_at_[v].empty()) return;
    gatherRing(v, faces_at_[v], faces_, ring_);
    Removal best{.cost = INFINITY, .vertex = v, .version = version};
    double area = 0;
    for (size_t i = 0; i < ring_.faces.size(); ++i)
      area += glm::length(glm::cross(positions_[ring_.vertices[i]] - positions_[v],
                                     positions_[ring_.next(i)] - positions_[v])) /
              2;
    for (size_t kept = 0; kept < ring_.size(); ++kept) {
      const uint32_t w = ring_.vertices[kept];
      const dvec3 step = positions_[w] - positions_[v];
      const double error =
          std::max(0.0, quadrics_[v].at(positions_[w])) + std::max(0.0, quadrics_[w].at(positions_[w]));
      const double cost = error + kLengthWeight * area * glm::dot(step, step);
      if (cost < best.cost && isAllowed(v, kept)) best.cost = cost, best.kept = kept;
    }
    if (best.cost < INFINITY) queue_.push(best);
  }

  bool isAllowed(uint32_t v, size_t kept) {
    if (ring_.is_open && kept != 0 && kept + 1 != ring_.size()) return false;
    return keepsTopology(v, kept) && keepsShape(v, kept);
  }

  // The link condition (Dey et al., 1999): the two ends share the neighbours that their common faces have, and no more;
  // and three faces about a vertex must not be closed by a fourth one.
  bool keepsTopology(uint32_t v, size_t kept) {
    const uint32_t w = ring_.vertices[kept];
    if (ring_.faces.size() < 2) return false;
    gatherNeighbours(w, others_);
    size_t shared = 0;
    for (uint32_t n : ring_.vertices) shared += std::binary_search(others_.begin(), others_.end(), n);
    if (shared != (ring_.is_open ? 1 : 2)) return false;
    if (others_.size() + ring_.size() - shared - 2 > std::max(limits_.most_neighbours, others_.size())) return false;
    if (ring_.is_open || ring_.size() != 3) return true;
    const auto isClosing = [&](uint32_t f) {
      return std::all_of(faces_[f].begin(), faces_[f].end(), [&](uint32_t n) {
        return n != v && std::find(ring_.vertices.begin(), ring_.vertices.end(), n) != ring_.vertices.end();
      });
    };
    return std::none_of(faces_at_[w].begin(), faces_at_[w].end(), isClosing);
  }
  void gatherNeighbours(uint32_t v, std::vector<uint32_t>& neighbours) const {
    neighbours.clear();
    for (uint32_t f : faces_at_[v])
      for (uint32_t n : faces_[f])
        if (n != v) neighbours.push_back(n);
    std::sort(neighbours.begin(), neighbours.end());
    neighbours.erase(std::unique(neighbours.begin(), neighbours.end()), neighbours.end());
  }

  bool keepsShape(uint32_t v, size_t kept) {
    const dvec3 &from = positions_[v], &to = positions_[ring_.vertices[kept]];
    dvec3 whole(0);
    for (size_t i = 0; i < ring_.faces.size(); ++i)
      whole += glm::cross(positions_[ring_.vertices[i]] - from, positions_[ring_.next(i)] - from);
    double worst_before = 1, worst_after = 1;
    for (size_t i = 0; i < ring_.faces.size(); ++i) {
      const dvec3 &a = positions_[ring_.vertices[i]], &b = positions_[ring_.next(i)];
      const double quality = triangleQuality(from, a, b);
      worst_before = std::min(worst_before, quality);
      if (i == kept || (i + 1) % ring_.size() == kept) continue;
      worst_after = std::min(worst_after, triangleQuality(to, a, b));
      // What a sliver's own normal says means nothing.
      const dvec3 before = quality < kSliver ? whole : glm::cross(a - from, b - from),
                  after = glm::cross(a - to, b - to);
      if (glm::dot(before, after) <= limits_.least_cosine * glm::length(before) * glm::length(after)) return false;
    }
    const double least = std::min(limits_.least_quality, 0.9 * worst_before);
    return worst_after >= least && layOut(v, ring_, straightPath(v, kept), positions_, flat_) &&
           fanFills(flat_, kept, ring_.is_open, 0.5 * least);
  }

  // The border or crease through `v` that goes on after `kept` has taken its place: its neighbour on the other side of
  // v.
  uint32_t courseBeyond(uint32_t v, const Ring& ring, size_t kept) const {
    if (ring.is_open) return kept == 0 ? ring.vertices.back() : ring.vertices.front();
    const uint32_t w = ring.vertices[kept];
    if (along_[v].size() != 2 || (along_[v][0] != w && along_[v][1] != w)) return kNoIndex;
    return along_[v][along_[v][0] == w];
  }
  StraightPath straightPath(uint32_t v, size_t kept) const {
    const uint32_t other = courseBeyond(v, ring_, kept);
    if (ring_.is_open || other == kNoIndex) return {0, 0};
    const auto found = std::find(ring_.vertices.begin(), ring_.vertices.end(), other);
    return {kept, static_cast<size_t>(found - ring_.vertices.begin())};
  }

  // --- taking it out

  void tryRemoval(const Removal& removal) {
    const uint32_t v = removal.vertex;
    gatherRing(v, faces_at_[v], faces_, ring_);
    if (!isAllowed(v, removal.kept)) {  // farther neighbours have changed
      enqueue(v);
      return;
    }
    map_.addStep(ring_, flat_, removal.kept);
    const Ring ring = ring_;
    take(v, ring, removal.kept);
    for (uint32_t n : ring.vertices) enqueue(n);
  }

  void take(uint32_t v, const Ring& ring, size_t kept) {
    const uint32_t w = ring.vertices[kept];
    takeCourses(v, w, courseBeyond(v, ring, kept));
    for (size_t i = 0; i < ring.faces.size(); ++i) {
      const uint32_t f = ring.faces[i];
      if (i == kept || (i + 1) % ring.size() == kept) {
        is_alive_[f] = false, --alive_;
        for (uint32_t n : faces_[f])
          if (n != v) std::erase(faces_at_[n], f);
      } else {
        faces_[f][ring.corners[i]] = w;
        faces_at_[w].push_back(f);
      }
    }
    faces_at_[v].clear();
    quadrics_[w].add(quadrics_[v]);
    ++versions_[v];
  }
  // Joins the courses from w to v and from v to `other`; any others at v end.
  void takeCourses(uint32_t v, uint32_t w, uint32_t other) {
    if (other != kNoIndex) {
      Chain course = courseFrom(w, v);
      const Chain rest = courseFrom(v, other);
      course.vertices.push_back(v);
      course.vertices.insert(course.vertices.end(), rest.vertices.begin(), rest.vertices.end());
      course.edges.insert(course.edges.end(), rest.edges.begin(), rest.edges.end());
      courses_[std::minmax(w, other)] = turned(std::move(course), w > other);
      along_[w].push_back(other), along_[other].push_back(w);
    }
    for (uint32_t n : along_[v]) {
      courses_.erase(std::minmax(v, n));
      std::erase(along_[n], v);
    }
    along_[v].clear();
  }
  static Chain turned(Chain course, bool turns) {
    if (turns) {
      std::reverse(course.vertices.begin(), course.vertices.end());
      std::reverse(course.edges.begin(), course.edges.end());
    }
    return course;
  }
  Chain courseFrom(uint32_t a, uint32_t b) const { return turned(courses_.at(std::minmax(a, b)), a > b); }

  // --- the result

  Base finish() {
    Base base{.vertices = {}, .faces = {}, .numbers = {}, .map = std::move(map_), .courses = {}};
    std::vector<uint32_t> names(positions_.size(), kNoIndex);
    for (uint32_t v = 0; v < positions_.size(); ++v) {
      if (faces_at_[v].empty()) continue;
      names[v] = static_cast<uint32_t>(base.vertices.size());
      base.vertices.push_back(v);
    }
    for (uint32_t f = 0; f < faces_.size(); ++f) {
      if (!is_alive_[f]) continue;
      base.faces.push_back({names[faces_[f][0]], names[faces_[f][1]], names[faces_[f][2]]});
      base.numbers.push_back(f);
    }
    for (auto& [ends, course] : courses_) {
      course.vertices.insert(course.vertices.begin(), ends.first);
      course.vertices.push_back(ends.second);
      base.courses.push_back(std::move(course));
    }
    return base;
  }

  const Original& original_;
  const SimplifyOptions& options_;
  std::vector<dvec3> positions_;  // about the first one
  std::vector<Triangle> faces_;   // as they are by now
  std::vector<bool> is_alive_;
  uint32_t alive_;
  std::vector<std::vector<uint32_t>> faces_at_;  // of each vertex
  std::vector<Quadric> quadrics_;
  std::vector<std::vector<uint32_t>> along_;                // neighbours along border or crease
  std::map<std::pair<uint32_t, uint32_t>, Chain> courses_;  // from the lower end; paths without their ends
  std::vector<uint32_t> versions_;
  std::priority_queue<Removal> queue_;
  CoarseMap map_;
  Limits limits_{};
  Ring ring_;  // scratch
  std::vector<glm::dvec2> flat_;
  std::vector<uint32_t> others_;
};

}  // namespace

Base simplify(const Original& original, const SimplifyOptions& options) { return Simplifier(original, options).run(); }

}  // namespace foreland::terrain
