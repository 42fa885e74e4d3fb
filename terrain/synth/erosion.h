// Landscape evolution on a square grid: rivers cut in proportion to a power of their drainage area times their slope,
// while the ground is lifted; slopes steeper than scree collapse. Braun and Willett, "A very efficient O(n),
// implicit and parallel method to solve the stream power equation" (2013); drainage by Barnes et al., "Priority-flood"
// (2014), so lakes drain over their lowest pass. The steepest of eight neighbours is chosen with a small random
// preference, which differs from step to step, so that slopes do not follow the eight directions of the grid.
// Deterministic. One owner.
#pragma once

#include <cstdint>
#include <vector>

namespace foreland::terrain {

struct ErosionGrid {
  uint32_t size = 0;  // samples a side
  double cell = 1;    // distance between samples, in the unit of the heights
  std::vector<float> height;
  std::vector<float> uplift;  // per unit of time; 0 on the border, whose heights never change
};

struct ErosionStep {
  double time = 1;
  double erodibility = 1;  // K of dh/dt = U - K A^0.45 S, with A in squares of the length unit
  double talus = 1;        // steepest stable slope along a flow path; it varies by a third with the rock
  uint32_t seed = 0;       // of the random choices; a different one for each step
  double diffusion = 0;    // hillslope creep: share of the distance to the neighbours' mean, 0 to 0.25
};

struct Alluvium {
  double depth = 1;     // of the gravel under the largest rivers
  double min_area = 1;  // drained by a river that leaves any
  uint32_t seed = 0;
};

class Eroder {
 public:
  void run(ErosionGrid& grid, const ErosionStep& step);
  // Fills the notches that rivers cut to flat floors, wider the more water there is.
  void fillValleys(ErosionGrid& grid, const Alluvium& gravel);

 private:
  void routeWater(const ErosionGrid& grid, uint32_t seed);
  void collectArea(const ErosionGrid& grid);
  void cut(ErosionGrid& grid, const ErosionStep& step) const;
  void creep(ErosionGrid& grid, double share);

  std::vector<uint32_t> order_;     // cells from the outlets upward
  std::vector<uint32_t> receiver_;  // where a cell's water goes; itself at an outlet
  std::vector<float> area_;         // in cells
  std::vector<float> filled_;       // height of the water surface
};

}  // namespace foreland::terrain
