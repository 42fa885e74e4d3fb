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

  // Of a sample in the window.
  float at(uint32_t x, uint32_t y) const {
    return metres[static_cast<size_t>(y - window.y) * window.width + (x - window.x)];
  }

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

// Where the epoch's samples are on the lattice of `base`. An Error that names the epoch's file if it is on another
// lattice or in another reference system than `base`, or reaches beyond it (P, definition 2: key geometries refine the
// same base complex). Nowhere if the epoch has no source.
Result<proto::LatticeWindow> windowOf(const EpochRequest& epoch, const ElevationInfo& base);
// An Error is that of the first epoch that has one, or of checkDates().
Status checkEpochs(const std::vector<EpochRequest>& epochs, const ElevationInfo& base);

// What the epoch says of the samples of a window.
Result<EpochSamples> readEpoch(const EpochRequest& epoch, const ElevationInfo& base, const proto::LatticeWindow& part);

Error heightDoesNotFit(const std::string& date, float metres);

// Elevation as it is at the first epoch, which is laid over it. Both sources have to outlive it.
class FirstEpoch final : public ElevationSource {
 public:
  // `window` is the epoch's, by windowOf().
  FirstEpoch(ElevationSource& base, const EpochRequest& epoch, const proto::LatticeWindow& window)
      : base_(base), epoch_(epoch.source), window_(window) {}
  const ElevationInfo& info() const override { return base_.info(); }
  Status readRows(uint32_t first, uint32_t count, std::span<float> out) override;
  const SparseHeights* sparse() const override { return base_.sparse(); }
  std::vector<std::string> warnings() const override { return base_.warnings(); }

 private:
  ElevationSource& base_;
  ElevationSource* epoch_;  // null: nothing changes
  proto::LatticeWindow window_;
};

}  // namespace foreland::terrain
