// Reads the heights of an epoch from elevation data that covers a scene's samples or some of them. Pure but for the
// source; one caller.
#pragma once

#include <cmath>
#include <string>
#include <vector>

#include "base/result.h"
#include "base/time.h"
#include "proto/section/epochs.h"
#include "terrain/elevation_source.h"

namespace foreland::terrain {

struct EpochRequest {
  Time time;                          // since 1970, UTC
  std::string date;                   // as the user wrote it
  ElevationSource* source = nullptr;  // null: the ground is as at the epoch before
};

struct EpochSamples {
  Time time;
  std::string date;
  proto::LatticeWindow window;  // on the scene's lattice
  std::vector<float> metres;    // of the window, row by row from the south; kVoid where the epoch says nothing

  // Calls visit(x, y, metres) for each sample of which the epoch says something.
  template <class Visit>
  void forEach(const Visit& visit) const {
    for (uint32_t row = 0; row < window.height; ++row)
      for (uint32_t column = 0; column < window.width; ++column)
        if (const float height = metres[static_cast<size_t>(row) * window.width + column]; !std::isnan(height))
          visit(window.x + column, window.y + row, height);
  }
};

// An Error if dates are out of order or twice, and names the first such date.
Status checkDates(const std::vector<EpochRequest>& epochs);

// Whether samples lie on the lattice of `base`, in its reference system, be it within its data or not.
bool isOnLatticeOf(const ElevationInfo& epoch, const ElevationInfo& base);

// An Error that names the epoch's file if it is on another lattice or in another reference system than `base`, or
// reaches beyond it (P, definition 2: key geometries refine the same base complex).
Result<EpochSamples> readEpoch(const EpochRequest& epoch, const ElevationInfo& base);

}  // namespace foreland::terrain
