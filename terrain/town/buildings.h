// The houses of a synthetic town, as polygon models: closed, of one piece, upright, about the origin in plan, the
// ground at z = 0. Walls go down below the ground, have windows, and colours of their own. Pure; any thread.
#pragma once

#include <cstdint>
#include <glm/vec2.hpp>
#include <string>
#include <vector>

#include "terrain/model/model.h"

namespace foreland::terrain {

inline constexpr double kFoundation_m = 4;  // below the ground

enum class BuildingUse : uint8_t { kHouse, kCorner, kChurch, kTower };

struct Building {
  std::string name;
  BuildingUse use = BuildingUse::kHouse;
  glm::dvec2 size{
      0};  // of its plan along x, the front, which looks to -y, and along y. A corner's wings are at -x and -y
  double height = 0;  // above the ground
  Model model;
};

// A dozen houses for streets, two for corners, a church and a tower.
std::vector<Building> makeBuildings();

}  // namespace foreland::terrain
