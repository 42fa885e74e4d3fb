// The ground of a window of a scene's samples, moved from epoch to epoch, and what must hold at all times: the lowest
// and the highest height of each sample, and the grounds whose errors count. Between two epochs heights are convex
// combinations of the epochs', so an error is largest at an epoch, and the ground lies between its lowest and its
// highest epoch; with a Catmull-Rom blend they are convex combinations of the epochs' and of control heights
// (proto::EpochCurve), so the grounds that these make count like epochs. Control heights are rounded to a 64th of a
// quantum, which errors pay for.
//
// One owner. Memory: 12 bytes a sample; with Catmull-Rom 24.
#pragma once

#include <array>
#include <functional>
#include <span>
#include <vector>

#include "base/result.h"
#include "proto/section/epochs.h"
#include "proto/space/frame.h"
#include "terrain/epochs/read_epoch.h"

namespace foreland::terrain {

// A ground whose errors count.
struct GroundAtTime {
  std::span<const int32_t> quanta;  // of the walk's window, row by row from the south
  const proto::Frame& frame;        // has the quantum
  double rounding_m = 0;            // by which errors are larger than those of the quanta, at most
  proto::LatticeWindow changed;     // where it may differ from the grounds before
};

// From the epoch before to an epoch.
struct EpochChange {
  proto::LatticeWindow window;  // the smallest that holds it
  uint64_t samples = 0;
  double max_m = 0;  // by which a height changed
};

class EpochWalk {
 public:
  using Visit = std::function<Status(const GroundAtTime&)>;

  // `first` are the heights of the window at the first epoch. All must outlive the walk; `dates` are all epochs',
  // whatever their windows.
  EpochWalk(const proto::LatticeWindow& window, const proto::Frame& frame, std::span<const int32_t> first,
            const proto::Epochs& dates);

  // Moves the ground to the next epoch, and visits the grounds that become known by it. Samples outside of the window
  // are left out. An Error names the epoch, or is the visit's.
  Status next(const EpochSamples& epoch, const Visit& visit);

  std::span<const int32_t> ground() const { return ground_; }
  std::span<const int32_t> lowest() const { return lowest_; }
  std::span<const int32_t> highest() const { return highest_; }
  const EpochChange& change() const { return change_; }

 private:
  Status move(const EpochSamples& epoch);
  Status visitControls(const Visit& visit);
  Status visitControl(const proto::LatticeWindow& changed, const std::array<double, 3>& weights, const Visit& visit);

  proto::LatticeWindow window_;
  const proto::Frame& frame_;
  const proto::Epochs& dates_;
  uint32_t epoch_ = 0;                              // at which the ground is
  std::vector<int32_t> ground_, lowest_, highest_;  // at the last epoch; over all so far
  // With Catmull-Rom the ground at the epoch before the last, and at the one before that; and a ground of control
  // heights, in 64ths of quanta.
  std::vector<int32_t> before_, before_that_, control_;
  EpochChange change_;
  proto::LatticeWindow changed_before_;  // from the one before that to the epoch before the last
};

}  // namespace foreland::terrain
