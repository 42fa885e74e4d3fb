#include <algorithm>
#include <map>
#include <tuple>

#include "terrain/remesh/lattice/crossings.h"
#include "terrain/remesh/lattice/embedding.h"

namespace foreland::terrain {

namespace {

using glm::dvec3;

// Fractions of a lattice edge.
constexpr double kFarthest = 0.75;  // vertices do not move further along it
constexpr double kThere = 1e-6;     // a crease this near a vertex passes through it

class Snapper {
 public:
  Snapper(const Original& surface, const std::vector<Chain>& chains, const Base& base, const Lattice& lattice,
          Embedding& embedding)
      : surface_(surface),
        chains_(chains),
        finder_(surface, base, lattice),
        embedding_(embedding),
        first_curve_(static_cast<uint32_t>(embedding.curves.size())) {
    for (const Chain& chain : chains) {
      crossings_.push_back(finder_.along(chain));
      embedding.curves.emplace_back(surface, chain);
    }
    for (const auto& crossings : crossings_) is_resolved_.emplace_back(crossings.size());
  }

  // The ends of chains are snapped first, then the crossings, those nearest to a vertex first.
  void run() {
    for (size_t c = 0; c < chains_.size(); ++c) snapEnds(c);
    struct Candidate {
      double fraction;
      uint32_t chain, number, end;
    };
    std::vector<Candidate> candidates;
    for (uint32_t c = 0; c < chains_.size(); ++c)
      for (uint32_t i = 0; i < crossings_[c].size(); ++i)
        for (uint32_t end : {0u, 1u}) {
          const double fraction = end == 0 ? crossings_[c][i].fraction : 1 - crossings_[c][i].fraction;
          if (fraction <= kFarthest) candidates.push_back({fraction, c, i, end});
        }
    std::sort(candidates.begin(), candidates.end(), [](const Candidate& a, const Candidate& b) {
      return std::tie(a.fraction, a.chain, a.number, a.end) < std::tie(b.fraction, b.chain, b.number, b.end);
    });
    for (const Candidate& candidate : candidates) {
      const Crossing& crossing = crossings_[candidate.chain][candidate.number];
      const uint32_t v = crossing.ends[candidate.end];
      if (is_resolved_[candidate.chain][candidate.number]) continue;
      if (!isFree(v) && candidate.fraction > kThere) continue;
      if (isFree(v)) moveTo(v, candidate.chain, crossing.point);
      resolve(candidate.chain, candidate.number, v);
    }
  }

 private:
  bool isFree(uint32_t v) const { return embedding_.constraints[v] == Constraint::kFree; }
  void moveTo(uint32_t v, uint32_t chain, const SurfacePoint& point) {
    const uint32_t curve = first_curve_ + chain;
    const double along = embedding_.curves[curve].nearest(positionOf(point, surface_.positions, surface_.faces));
    embedding_.putOnCurve(v, curve, along);
  }

  // Fixes the lattice vertex nearest to each end of a chain at that end.
  void snapEnds(size_t c) {
    const Chain& chain = chains_[c];
    const size_t last = chain.edges.size() - 1;
    for (const size_t at : {size_t{0}, last}) {
      const uint32_t vertex = at == 0 ? chain.vertices.front() : chain.vertices.back();
      const SurfacePoint point = cornerOf(chain.edges[at], vertex);
      const LatticeCell cell = finder_.cellOf(point);
      const int k = cell.weights.x >= cell.weights.y && cell.weights.x >= cell.weights.z ? 0
                    : cell.weights.y >= cell.weights.z                                   ? 1
                                                                                         : 2;
      const uint32_t v = cell.vertices[static_cast<size_t>(k)];
      const bool is_there = cell.weights[k] > 1 - kThere;
      const auto taken = taken_.try_emplace(vertex, !isFree(v) && !is_there ? kNoIndex : v).first->second;
      if (taken != v) continue;
      if (isFree(v)) embedding_.fix(v, point);
      if (!crossings_[c].empty()) resolveFromEnd(c, at == 0, v);
    }
  }
  SurfacePoint cornerOf(uint32_t edge, uint32_t vertex) const {
    const Triangle& t = surface_.faces[edge / 3];
    SurfacePoint point{edge / 3, dvec3(0)};
    point.weights[static_cast<int>(std::find(t.begin(), t.end(), vertex) - t.begin())] = 1;
    return point;
  }

  bool resolveOne(size_t c, size_t i, uint32_t v) {
    const auto& ends = crossings_[c][i].ends;
    if (ends[0] != v && ends[1] != v) return false;
    is_resolved_[c][i] = true;
    return true;
  }
  // The crease now passes through v, so the consecutive crossings of v's edges around crossing i no longer exist.
  void resolve(size_t c, size_t i, uint32_t v) {
    for (size_t j = i; j < crossings_[c].size() && resolveOne(c, j, v);) ++j;
    for (size_t j = i + 1; j-- > 0 && resolveOne(c, j, v);) continue;
  }
  void resolveFromEnd(size_t c, bool at_start, uint32_t v) {
    const size_t i = at_start ? 0 : crossings_[c].size() - 1;
    if (resolveOne(c, i, v)) resolve(c, i, v);
  }

  const Original& surface_;
  const std::vector<Chain>& chains_;
  CrossingFinder finder_;
  Embedding& embedding_;
  uint32_t first_curve_;                          // of the chains; base edges' curves come before
  std::vector<std::vector<Crossing>> crossings_;  // of each chain
  std::vector<std::vector<bool>> is_resolved_;
  std::map<uint32_t, uint32_t>
      taken_;  // the lattice vertex fixed at the original's vertex at a chain's end, or kNoIndex
};

}  // namespace

void snapToCreases(const Original& surface, EdgeFlags creases, const Base& base, const Lattice& lattice,
                   Embedding& embedding) {
  for (const Chain& chain : base.feature_chains)
    for (uint32_t edge : chain.edges)
      for (uint32_t side : {edge, surface.twins[edge / 3][edge % 3]})
        if (side != kNoIndex) creases[side / 3][side % 3] = false;
  const std::vector<Chain> chains = findChains(surface, creases);
  Snapper(surface, chains, base, lattice, embedding).run();
}

}  // namespace foreland::terrain
