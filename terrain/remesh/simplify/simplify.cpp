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

// What a collapse may do to the shape of triangles. The sets of limits are tried in turn until the target is reached.
struct Limits {
  double min_quality;  // of triangles, flattened and in space, unless they were worse before
  double min_cosine;   // between a face's normal before and after
  size_t max_valence;
};
constexpr std::array<Limits, 3> kLimits{{{0.2, 0.3, 9}, {0.05, 0.0, 12}, {0.005, -0.5, 24}}};

constexpr double kBorderWeight = 10, kCreaseWeight = 3;  // of their planes, relative to those of faces
constexpr double kLengthWeight =
    3e-3;  // of squared edge lengths relative to squared distances: evens out triangles on flat parts

constexpr double kSliver = 0.02;  // triangles of lower quality are slivers

struct Collapse {
  double cost = 0;
  uint32_t vertex = 0, version = 0;
  size_t kept = 0;  // index into the one-ring of the neighbour that `vertex` collapses into
  bool operator<(const Collapse& other) const {  // reversed: std::priority_queue returns the largest first
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
        const Collapse collapse = queue_.top();
        queue_.pop();
        if (collapse.version == versions_[collapse.vertex]) tryCollapse(collapse);
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
    const uint32_t a = faces_[f][k], b = faces_[f][(k + 1) % 3], beyond = original_.twins[f][k];
    const bool is_border = beyond == kNoIndex;
    if (!is_border && glm::dot(normal, normalOf(faces_[beyond / 3], positions_)) >= options_.crease_cosine) return;
    const dvec3 edge = positions_[b] - positions_[a];
    const double weight = importanceOf(f) * (is_border ? kBorderWeight : kCreaseWeight) * glm::dot(edge, edge);
    const dvec3 wall = glm::normalize(glm::cross(edge, normal));
    for (uint32_t v : {a, b}) quadrics_[v].addPlane(wall, positions_[v], weight);
    if (is_border || f < beyond / 3) {
      along_[a].push_back(b), along_[b].push_back(a);
      chains_[std::minmax(a, b)] = {{}, {3 * f + k}};
    }
  }

  double importanceOf(uint32_t f) const {
    if (options_.importance.empty()) return 1;
    double sum = 0;
    for (uint32_t v : faces_[f]) sum += options_.importance[v] / 3;
    return sum;
  }

  // --- choosing collapses

  void enqueue(uint32_t v) {
    const uint32_t version = ++versions_[v];
    if (faces_at_[v].empty()) return;
    gatherOneRing(v, faces_at_[v], faces_, ring_);
    Collapse best{.cost = INFINITY, .vertex = v, .version = version};
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

  // The link condition (Dey et al., 1999): the only common neighbours of both ends are those of their common faces; and
  // the three faces about a vertex of valence three must not be joined by a fourth into a closed tetrahedron.
  bool keepsTopology(uint32_t v, size_t kept) {
    const uint32_t w = ring_.vertices[kept];
    if (ring_.faces.size() < 2) return false;
    gatherNeighbours(w, others_);
    size_t shared = 0;
    for (uint32_t n : ring_.vertices) shared += std::binary_search(others_.begin(), others_.end(), n);
    if (shared != (ring_.is_open ? 1 : 2)) return false;
    if (others_.size() + ring_.size() - shared - 2 > std::max(limits_.max_valence, others_.size())) return false;
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
      // The normal of a sliver is noise, so the mean normal stands in for it.
      const dvec3 before = quality < kSliver ? whole : glm::cross(a - from, b - from),
                  after = glm::cross(a - to, b - to);
      if (glm::dot(before, after) <= limits_.min_cosine * glm::length(before) * glm::length(after)) return false;
    }
    const double least = std::min(limits_.min_quality, 0.9 * worst_before);
    return worst_after >= least && flatten(v, ring_, straightPath(v, kept), positions_, flat_) &&
           isValidFan(flat_, kept, ring_.is_open, 0.5 * least);
  }

  // If `v` and ring vertex `kept` lie on one border or crease: the next vertex of it on the other side of v. The chain
  // continues there after the collapse. kNoIndex otherwise.
  uint32_t chainBeyond(uint32_t v, const OneRing& ring, size_t kept) const {
    if (ring.is_open) return kept == 0 ? ring.vertices.back() : ring.vertices.front();
    const uint32_t w = ring.vertices[kept];
    if (along_[v].size() != 2 || (along_[v][0] != w && along_[v][1] != w)) return kNoIndex;
    return along_[v][along_[v][0] == w];
  }
  StraightPath straightPath(uint32_t v, size_t kept) const {
    const uint32_t other = chainBeyond(v, ring_, kept);
    if (ring_.is_open || other == kNoIndex) return {0, 0};
    const auto found = std::find(ring_.vertices.begin(), ring_.vertices.end(), other);
    return {kept, static_cast<size_t>(found - ring_.vertices.begin())};
  }

  // --- applying one

  void tryCollapse(const Collapse& collapse) {
    const uint32_t v = collapse.vertex;
    gatherOneRing(v, faces_at_[v], faces_, ring_);
    if (!isAllowed(v, collapse.kept)) {  // the two-ring has changed since it was queued
      enqueue(v);
      return;
    }
    map_.addRemoval(ring_, flat_, collapse.kept);
    const OneRing ring = ring_;
    apply(v, ring, collapse.kept);
    for (uint32_t n : ring.vertices) enqueue(n);
  }

  void apply(uint32_t v, const OneRing& ring, size_t kept) {
    const uint32_t w = ring.vertices[kept];
    joinChains(v, w, chainBeyond(v, ring, kept));
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
  // Joins the chains from w to v and from v to `other` into one; all other chains at v are dropped.
  void joinChains(uint32_t v, uint32_t w, uint32_t other) {
    if (other != kNoIndex) {
      Chain chain = chainFrom(w, v);
      const Chain rest = chainFrom(v, other);
      chain.vertices.push_back(v);
      chain.vertices.insert(chain.vertices.end(), rest.vertices.begin(), rest.vertices.end());
      chain.edges.insert(chain.edges.end(), rest.edges.begin(), rest.edges.end());
      chains_[std::minmax(w, other)] = reversedIf(w > other, std::move(chain));
      along_[w].push_back(other), along_[other].push_back(w);
    }
    for (uint32_t n : along_[v]) {
      chains_.erase(std::minmax(v, n));
      std::erase(along_[n], v);
    }
    along_[v].clear();
  }
  static Chain reversedIf(bool is_reversed, Chain chain) {
    if (is_reversed) {
      std::reverse(chain.vertices.begin(), chain.vertices.end());
      std::reverse(chain.edges.begin(), chain.edges.end());
    }
    return chain;
  }
  Chain chainFrom(uint32_t a, uint32_t b) const { return reversedIf(a > b, chains_.at(std::minmax(a, b))); }

  // --- the result

  Base finish() {
    Base base{.vertices = {}, .faces = {}, .map_faces = {}, .map = std::move(map_), .feature_chains = {}};
    std::vector<uint32_t> names(positions_.size(), kNoIndex);
    for (uint32_t v = 0; v < positions_.size(); ++v) {
      if (faces_at_[v].empty()) continue;
      names[v] = static_cast<uint32_t>(base.vertices.size());
      base.vertices.push_back(v);
    }
    for (uint32_t f = 0; f < faces_.size(); ++f) {
      if (!is_alive_[f]) continue;
      base.faces.push_back({names[faces_[f][0]], names[faces_[f][1]], names[faces_[f][2]]});
      base.map_faces.push_back(f);
    }
    for (auto& [ends, chain] : chains_) {
      chain.vertices.insert(chain.vertices.begin(), ends.first);
      chain.vertices.push_back(ends.second);
      base.feature_chains.push_back(std::move(chain));
    }
    return base;
  }

  const Original& original_;
  const SimplifyOptions& options_;
  std::vector<dvec3> positions_;  // relative to the first one
  std::vector<Triangle> faces_;   // after the collapses so far
  std::vector<bool> is_alive_;
  uint32_t alive_;
  std::vector<std::vector<uint32_t>> faces_at_;  // of each vertex
  std::vector<Quadric> quadrics_;
  std::vector<std::vector<uint32_t>> along_;  // of each vertex: its neighbours along borders and creases
  std::map<std::pair<uint32_t, uint32_t>, Chain>
      chains_;  // by their two ends, from the lower one; without the end vertices
  std::vector<uint32_t> versions_;
  std::priority_queue<Collapse> queue_;
  CoarseMap map_;
  Limits limits_{};
  OneRing ring_;  // scratch
  std::vector<glm::dvec2> flat_;
  std::vector<uint32_t> others_;
};

}  // namespace

Base simplify(const Original& original, const SimplifyOptions& options) { return Simplifier(original, options).run(); }

}  // namespace foreland::terrain
