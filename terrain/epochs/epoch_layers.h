// The ground of a scene epoch by epoch: what the scene file says of each (store/epoch_section.h), and what the bounds
// of nodes need in order to hold at all times. Between two epochs heights are convex combinations of the epochs', so an
// error is largest at an epoch, and the ground lies between its lowest and its highest epoch; with a Catmull-Rom blend
// they are convex combinations of the epochs' and of control heights (proto::EpochCurve), so the grounds that these
// make count like epochs. Control heights are rounded to a 64th of a quantum, which errors pay for.
//
// One owner. Memory: 12 bytes a sample and 9 a slot; with Catmull-Rom 24 a sample. Cost: for each epoch, bounds of the
// rows around what it covers; with Catmull-Rom three times that.
#pragma once

#include <array>
#include <functional>
#include <vector>

#include "base/result.h"
#include "terrain/bounds/bounds.h"
#include "terrain/epochs/read_epoch.h"
#include "terrain/store/scene.h"
#include "terrain/store/tables/epoch_section.h"

namespace foreland::terrain {

// What an epoch is and costs.
struct EpochReport {
  std::string date;
  uint64_t changed_samples = 0;  // since the epoch before
  double max_m = 0;              // by which a height changed since then
  uint64_t bytes = 0;            // in the scene file
};

class EpochLayers {
 public:
  // `first` is the ground at the first epoch; all must outlive it. `dates` are all epochs', whatever their windows.
  EpochLayers(const proto::GridTopology& grid, const proto::Frame& frame, Heights first, proto::Epochs dates,
              unsigned threads);

  // The first epoch; then the others, in order. `keepGoing` as in BoundsJob::onProgress.
  void begin(const EpochSamples& first);
  Status add(const EpochSamples& epoch, const std::function<bool(double)>& keepGoing);

  Heights lowest() const { return {lowest_, first_.width, first_.height}; }
  Heights highest() const { return {highest_, first_.width, first_.height}; }
  std::span<const proto::QuantisedError> minErrors() const { return min_errors_; }
  HeightRange range() const;
  Bytes section() const { return section_.bytes(); }
  const std::vector<EpochReport>& reports() const { return reports_; }

 private:
  using KeepGoing = std::function<bool(double)>;

  Status move(const EpochSamples& epoch, EpochReport& report);
  bool raiseErrors(const proto::LatticeWindow& rows, const KeepGoing& keepGoing);
  Status raiseToControls(const KeepGoing& keepGoing);
  Status raiseToControl(const proto::LatticeWindow& changed, const std::array<double, 3>& weights,
                        const KeepGoing& keepGoing);
  bool meets(proto::Slot slot, const proto::LatticeWindow& window) const;
  EpochBlocks offsets(uint32_t epoch);
  int32_t offsetAt(uint32_t x, uint32_t y) const;

  const proto::GridTopology& grid_;
  const proto::Frame& frame_;
  Heights first_;
  proto::Epochs dates_;
  unsigned threads_;
  // With Catmull-Rom the ground at the epoch before the last, and at the one before that; and a ground of control
  // heights, in 64ths of quanta.
  std::vector<int32_t> before_, before_that_, control_;
  proto::LatticeWindow changed_, changed_before_;  // from the epoch before the last to it, and from the one before that
  std::vector<int32_t> ground_, lowest_, highest_;  // at the last epoch; over all so far
  std::vector<proto::QuantisedError> min_errors_;
  std::vector<NodeRecord> scratch_;
  proto::LatticeWindow moved_;  // hull of all epochs' so far
  EpochSection section_;
  std::vector<EpochReport> reports_;
};

}  // namespace foreland::terrain
