// Where the vertices of a lattice lie on the original, and how free each of them is. Plain data; one owner.
#pragma once

#include <cstdint>
#include <vector>

#include "terrain/remesh/lattice/lattice.h"
#include "terrain/remesh/original/feature_curve.h"
#include "terrain/remesh/original/surface_point.h"
#include "terrain/remesh/simplify/simplify.h"

namespace foreland::terrain {

enum class Hold : uint8_t { kFree, kOnRail, kFixed };

struct Placement {
  explicit Placement(std::vector<SurfacePoint> at)
      : places(std::move(at)),
        holds(places.size(), Hold::kFree),
        rail_of(places.size(), kNoIndex),
        along(places.size(), 0.0) {}

  std::vector<SurfacePoint> places;
  std::vector<Hold> holds;
  std::vector<Rail> rails;  // first those of base edges, then the creases between
  size_t base_rails = 0;
  std::vector<uint32_t> rail_of;  // of those on a rail
  std::vector<double> along;      // where on it they stand

  void fix(uint32_t v, const SurfacePoint& place) {
    places[v] = place;
    holds[v] = Hold::kFixed;
  }
  void putOnRail(uint32_t v, uint32_t rail, double at) {
    places[v] = rails[rail].at(at);
    holds[v] = Hold::kOnRail, rail_of[v] = rail, along[v] = at;
  }
};

// Puts the lattice vertices of base edges that run along a border or crease onto it, next to where they are.
void layRails(const Original& surface, const Base& base, const Lattice& lattice, Placement& placement);

// Puts lattice vertices onto the creases that run between them, so that no triangle cuts a corner of the surface: where
// a crease crosses a lattice edge, one of its ends, the nearer if it is free, moves to the crossing. Few move: one that
// has moved settles the crossings around it.
void snapToCreases(const Original& surface, EdgeFlags creases, const Base& base, const Lattice& lattice,
                   Placement& placement);

}  // namespace foreland::terrain
