// The closed shell of a building: what is under roofs that are functions of the plan, part by part, from a flat bottom
// up. Along the lines of a grid that all parts share, walls stand where roofs differ. Windows are set into outer walls.
// One owner.
#pragma once

#include <array>
#include <functional>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <vector>

#include "terrain/model/model.h"

namespace foreland::terrain {

// A rectangle of the plan under one roof: `height` is linear between the lines of the grid and their diagonals.
struct Part {
  glm::dvec2 low{0}, high{0};
  std::function<double(const glm::dvec2&)> height;
  std::vector<double> xs{}, ys{};  // lines at which the roof bends
  Colour wall{}, roof{};
  bool has_windows = true;
};

// Where windows are, for all walls alike, so that walls meet without gaps.
struct Facade {
  double storey_m = 3.1, sill_m = 1.0, window_m = 1.6;  // heights: of a storey, of a sill in it, of a window
  double pitch_m = 2.7, width_m = 1.2;                  // along the wall
  double recess_m = 0.15;
  Colour window{70, 80, 95, 255};
};

// Where parts overlap, the last one stands. The bottom is at `bottom_m`.
Model makeShell(const std::string& name, const std::vector<Part>& parts, double bottom_m, const Facade& facade);

}  // namespace foreland::terrain
