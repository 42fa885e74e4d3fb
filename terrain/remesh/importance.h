// How much each part of the original matters to the next attempt: more where the last one was far from it, or folded.
// One owner.
#pragma once

#include <compare>
#include <span>
#include <vector>

#include "terrain/compare/closest.h"
#include "terrain/remesh/original/original.h"
#include "terrain/remesh/original/surface_point.h"

namespace foreland::terrain {

class Importance {
 public:
  Importance(const Original& original, unsigned threads);

  std::span<const double> weights() const { return weights_; }  // of each vertex; 1 at first

  // How bad an attempt was: first of all whether triangles fold, then how far the original's vertices lie from it.
  struct Badness {
    bool is_folded = true;
    double distance = 0;  // the largest, made larger by each triangle that folds
    auto operator<=>(const Badness&) const = default;
  };
  // Takes note of an attempt.
  Badness learn(const std::vector<Triangle>& triangles, const std::vector<glm::dvec3>& positions,
                const std::vector<SurfacePoint>& places);

 private:
  void spread(std::vector<double>& shares) const;

  const Original& original_;
  unsigned threads_;
  ClosestPoint surface_;  // the original
  std::vector<double> weights_;
};

}  // namespace foreland::terrain
