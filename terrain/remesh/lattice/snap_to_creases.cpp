#include <algorithm>
#include <map>
#include <tuple>

#include "terrain/remesh/lattice/crossings.h"
#include "terrain/remesh/lattice/embedding.h"

namespace foreland::terrain {

namespace {

using glm::dvec3;

constexpr double kFarthest = 0.75;  // of a lattice edge: vertices do not move further along it
constexpr double kThere = 1e-6;     // of a lattice edge: a crease this near a vertex runs through it

class Snapper {
 public:
  Snapper(const Original& surface, const std::vector<Chain>& chains, const Base& base, const Lattice& lattice,
          Placement& placement)
      : surface_(surface),
        chains_(chains),
        finder_(surface, base, lattice),
        placement_(placement),
        first_rail_(static_cast<uint32_t>(placement.rails.size())) {
    for (const Chain& chain : chains) {
      crossings_.push_back(finder_.along(chain));
      placement.rails.emplace_back(surface, chain);
    }
    for (const auto& crossings : crossings_) is_settled_.emplace_back(crossings.size());
  }

  // First the chains' ends, then the crossings, those nearest to a vertex first.
  void run() {
    for (size_t c = 0; c < chains_.size(); ++c) snapEnds(c);
    struct Candidate {
      double share;
      uint32_t chain, number, end;
    };
    std::vector<Candidate> candidates;
    for (uint32_t c = 0; c < chains_.size(); ++c)
      for (uint32_t i = 0; i < crossings_[c].size(); ++i)
        for (uint32_t end : {0u, 1u}) {
          const double share = end == 0 ? crossings_[c][i].share : 1 - crossings_[c][i].share;
          if (share <= kFarthest) candidates.push_back({share, c, i, end});
        }
    std::sort(candidates.begin(), candidates.end(), [](const Candidate& a, const Candidate& b) {
      return std::tie(a.share, a.chain, a.number, a.end) < std::tie(b.share, b.chain, b.number, b.end);
    });
    for (const Candidate& candidate : candidates) {
      const Crossing& crossing = crossings_[candidate.chain][candidate.number];
      const uint32_t v = crossing.ends[candidate.end];
      if (is_settled_[candidate.chain][candidate.number]) continue;
      if (!isFree(v) && candidate.share > kThere) continue;
      if (isFree(v)) moveTo(v, candidate.chain, crossing.place);
      settle(candidate.chain, candidate.number, v);
    }
  }

 private:
  bool isFree(uint32_t v) const { return placement_.holds[v] == Hold::kFree; }
  void moveTo(uint32_t v, uint32_t chain, const SurfacePoint& place) {
    const uint32_t rail = first_rail_ + chain;
    const double along = placement_.rails[rail].nearest(placeOf(place, surface_.positions, surface_.faces));
    placement_.putOnRail(v, rail, along);
  }

  // The lattice vertex nearest to each end of a chain goes there.
  void snapEnds(size_t c) {
    const Chain& chain = chains_[c];
    const size_t last = chain.edges.size() - 1;
    for (const size_t at : {size_t{0}, last}) {
      const uint32_t vertex = at == 0 ? chain.vertices.front() : chain.vertices.back();
      const SurfacePoint place = cornerOf(chain.edges[at], vertex);
      const LatticeCell cell = finder_.cellOf(place);
      const int k = cell.weights.x >= cell.weights.y && cell.weights.x >= cell.weights.z ? 0
                    : cell.weights.y >= cell.weights.z                                   ? 1
                                                                                         : 2;
      const uint32_t v = cell.vertices[static_cast<size_t>(k)];
      const bool is_there = cell.weights[k] > 1 - kThere;
      const auto taken = taken_.try_emplace(vertex, !isFree(v) && !is_there ? kNoIndex : v).first->second;
      if (taken != v) continue;
      if (isFree(v)) placement_.fix(v, place);
      if (!crossings_[c].empty()) settleFromEnd(c, at == 0, v);
    }
  }
  SurfacePoint cornerOf(uint32_t edge, uint32_t vertex) const {
    const Triangle& t = surface_.faces[edge / 3];
    SurfacePoint place{edge / 3, dvec3(0)};
    place.weights[static_cast<int>(std::find(t.begin(), t.end(), vertex) - t.begin())] = 1;
    return place;
  }

  bool settleOne(size_t c, size_t i, uint32_t v) {
    const auto& ends = crossings_[c][i].ends;
    if (ends[0] != v && ends[1] != v) return false;
    is_settled_[c][i] = true;
    return true;
  }
  // The crease now passes through v, so it crosses none of the edges there that it crossed around here.
  void settle(size_t c, size_t i, uint32_t v) {
    for (size_t j = i; j < crossings_[c].size() && settleOne(c, j, v);) ++j;
    for (size_t j = i + 1; j-- > 0 && settleOne(c, j, v);) continue;
  }
  void settleFromEnd(size_t c, bool at_start, uint32_t v) {
    const size_t i = at_start ? 0 : crossings_[c].size() - 1;
    if (settleOne(c, i, v)) settle(c, i, v);
  }

  const Original& surface_;
  const std::vector<Chain>& chains_;
  CrossingFinder finder_;
  Placement& placement_;
  uint32_t first_rail_;                           // of the chains'
  std::vector<std::vector<Crossing>> crossings_;  // of each chain
  std::vector<std::vector<bool>> is_settled_;
  std::map<uint32_t, uint32_t> taken_;  // the lattice vertex at a chain's end
};

}  // namespace

void snapToCreases(const Original& surface, EdgeFlags creases, const Base& base, const Lattice& lattice,
                   Placement& placement) {
  for (const Chain& course : base.courses)
    for (uint32_t edge : course.edges)
      for (uint32_t side : {edge, surface.across[edge / 3][edge % 3]})
        if (side != kNoIndex) creases[side / 3][side % 3] = false;
  const std::vector<Chain> chains = findChains(surface, creases);
  Snapper(surface, chains, base, lattice, placement).run();
}

}  // namespace foreland::terrain
