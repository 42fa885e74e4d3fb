#include <algorithm>
#include <map>
#include <utility>

#include "terrain/remesh/lattice/embedding.h"

namespace foreland::terrain {

namespace {

std::pair<uint32_t, uint32_t> endsOf(uint32_t a, uint32_t b) { return {std::min(a, b), std::max(a, b)}; }

}  // namespace

void layRails(const Original& surface, const Base& base, const Lattice& lattice, Placement& placement) {
  std::map<std::pair<uint32_t, uint32_t>, uint32_t> edges;
  for (uint32_t e = 0; e < lattice.edgeCount(); ++e)
    edges[endsOf(base.vertices[lattice.edge(e).from], base.vertices[lattice.edge(e).to])] = e;
  for (const Chain& course : base.courses) {
    const uint32_t e = edges.at(endsOf(course.vertices.front(), course.vertices.back()));
    const auto number = static_cast<uint32_t>(placement.rails.size());
    const Rail& rail = placement.rails.emplace_back(surface, course);
    std::vector<double> along;
    for (uint32_t step = 1; step < lattice.side(); ++step)
      along.push_back(
          rail.nearest(placeOf(placement.places[lattice.edgeVertex(e, step)], surface.positions, surface.faces)));
    // Rounding, or a crease that comes back near itself, may have put neighbours in the wrong order.
    std::sort(along.begin(), along.end());
    const bool is_forward = course.vertices.front() == base.vertices[lattice.edge(e).from];
    for (uint32_t step = 1; step < lattice.side(); ++step)
      placement.putOnRail(lattice.edgeVertex(e, step), number,
                          is_forward ? along[step - 1] : along[lattice.side() - 1 - step]);
  }
  placement.base_rails = placement.rails.size();
}

}  // namespace foreland::terrain
