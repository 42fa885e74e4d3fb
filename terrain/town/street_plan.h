// Where the houses of a synthetic town stand: along the streets around blocks of 60 to 100 m, with a place in the
// middle that has the church and the tower. Streets are 12 to 20 m wide from house to house and bend a little. The same
// arguments give the same town. Pure; any thread.
#pragma once

#include <cstdint>
#include <glm/vec2.hpp>
#include <span>
#include <vector>

#include "terrain/town/buildings.h"

namespace foreland::terrain {

struct PlacedBuilding {
  uint32_t building = 0;   // its index
  glm::dvec2 at{0};        // metres from the town's middle, east and north
  double heading_rad = 0;  // of its y axis, clockwise from north
};

struct StreetPlan {
  std::vector<PlacedBuilding> buildings;  // from the middle out
  double radius_m = 0;                    // of the circle that holds them
};

// `count` buildings, at least 1. No two stand on the same ground.
StreetPlan planStreets(uint32_t count, std::span<const Building> buildings, uint64_t seed);

}  // namespace foreland::terrain
