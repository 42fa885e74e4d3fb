#include <algorithm>
#include <map>
#include <utility>

#include "terrain/remesh/lattice/embedding.h"

namespace foreland::terrain {

namespace {

std::pair<uint32_t, uint32_t> endsOf(uint32_t a, uint32_t b) { return {std::min(a, b), std::max(a, b)}; }

}  // namespace

void constrainToCurves(const Original& surface, const Base& base, const Lattice& lattice, Embedding& embedding) {
  std::map<std::pair<uint32_t, uint32_t>, uint32_t> edges;
  for (uint32_t e = 0; e < lattice.edgeCount(); ++e)
    edges[endsOf(base.vertices[lattice.edge(e).from], base.vertices[lattice.edge(e).to])] = e;
  for (const Chain& chain : base.feature_chains) {
    const uint32_t e = edges.at(endsOf(chain.vertices.front(), chain.vertices.back()));
    const auto number = static_cast<uint32_t>(embedding.curves.size());
    const FeatureCurve& curve = embedding.curves.emplace_back(surface, chain);
    std::vector<double> along;
    for (uint32_t i = 1; i < lattice.side(); ++i)
      along.push_back(
          curve.nearest(positionOf(embedding.points[lattice.edgeVertex(e, i)], surface.positions, surface.faces)));
    // Rounding, or a crease that passes close to itself, may have put neighbours in the wrong order.
    std::sort(along.begin(), along.end());
    const bool is_forward = chain.vertices.front() == base.vertices[lattice.edge(e).from];
    for (uint32_t i = 1; i < lattice.side(); ++i)
      embedding.putOnCurve(lattice.edgeVertex(e, i), number, is_forward ? along[i - 1] : along[lattice.side() - 1 - i]);
  }
  embedding.base_curves = embedding.curves.size();
}

}  // namespace foreland::terrain
