// How fast, how far apart and how high things go over a scene that is fine in places: a share of what they do over the
// rest, so that where ten times as much is to be seen a camera comes down and slows down. Immutable; any thread.
#pragma once

#include <glm/vec2.hpp>
#include <vector>

#include "terrain/store/scene.h"

namespace foreland::server {

class Pace {
 public:
  // With the metres between lattice positions along both axes, and within which the pace falls from 1 to nothing, so
  // that nothing changes at once. Time and memory: those of the blocks of pages.
  Pace(const terrain::Scene& scene, glm::dvec2 spacing_m, double fall_m);

  // Where samples lie as close as everywhere, and far from all others, 1; else the root of how much closer they lie.
  // The root, for at a share of the height and the speed the ground goes by as fast as before, with more detail.
  double at(glm::dvec2 lattice) const;

 private:
  // Of pages of one level, in one block.
  struct Fine {
    glm::dvec2 low, high;  // on the lattice
    double pace;
  };
  std::vector<Fine> fine_;
  glm::dvec2 spacing_m_;
  double fall_m_;
};

}  // namespace foreland::server
