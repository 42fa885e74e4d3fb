// Triangles per second of refinement from scratch. One owner; times the thread that calls it.
#pragma once

#include <vector>

#include "proto/refine/metric/metric.h"
#include "proto/refine/refine.h"
#include "server/section/hierarchy.h"

namespace foreland::lab {

struct RefineSpeed {
  double nodes = 0, triangles = 0, ms = 0;          // medians over the views
  double mtri_per_s = 0, mtri_per_s_deviation = 0;  // median over the views, and median absolute deviation from it
};

// Collects the times of each view over several rounds, which may lie before and after something that it is compared
// with.
class RefineTimer {
 public:
  RefineTimer(const server::Hierarchy& hierarchy, std::vector<proto::View> views);

  // Refines each view `rounds` times.
  void measure(int rounds);
  // Each view counts with the median of its rounds.
  RefineSpeed speed() const;

 private:
  struct Sample {
    proto::View view;
    double nodes = 0, triangles = 0;
    std::vector<double> seconds;
  };

  const server::Hierarchy& hierarchy_;
  std::vector<Sample> samples_;
  proto::RefineScratch scratch_;
  proto::Section section_;
};

}  // namespace foreland::lab
