// The ground of a scene epoch by epoch: what the scene file says of each (store/epoch_section.h), and what the bounds
// of nodes need in order to hold at all times. Since heights between two epochs are linear in time, an error is largest
// at an epoch, and the ground lies between its lowest and its highest epoch.
//
// One owner. Memory: 12 bytes a sample and 9 a slot. Cost: for each epoch, bounds of the rows around what it covers.
#pragma once

#include <functional>
#include <vector>

#include "base/result.h"
#include "terrain/bounds/bounds.h"
#include "terrain/epochs/read_epoch.h"
#include "terrain/store/epoch_section.h"
#include "terrain/store/scene.h"

namespace foreland::terrain {

// What an epoch is and costs.
struct EpochReport {
  std::string date;
  uint64_t changed_samples = 0;  // since the epoch before
  double most_m = 0;             // by which a height changed since then
  uint64_t bytes = 0;            // in the scene file
};

class EpochLayers {
 public:
  // `first` is the ground at the first epoch; all must outlive it.
  EpochLayers(const proto::GridTopology& grid, const proto::Frame& frame, Heights first, unsigned threads);

  // The first epoch; then the others, in order. `keepGoing` as in BoundsJob::onProgress.
  void begin(const EpochSamples& first);
  Status add(const EpochSamples& epoch, const std::function<bool(double)>& keepGoing);

  Heights lowest() const { return {lowest_, first_.width, first_.height}; }
  Heights highest() const { return {highest_, first_.width, first_.height}; }
  std::span<const proto::QuantisedError> leastErrors() const { return least_errors_; }
  HeightRange range() const;
  Bytes section() const { return section_.bytes(); }
  const std::vector<EpochReport>& reports() const { return reports_; }

 private:
  Status move(const EpochSamples& epoch, EpochReport& report);
  bool raiseErrors(const proto::LatticeWindow& rows, const std::function<bool(double)>& keepGoing);
  EpochBlocks offsets(uint32_t epoch);
  int32_t offsetAt(uint32_t x, uint32_t y) const;

  const proto::GridTopology& grid_;
  const proto::Frame& frame_;
  Heights first_;
  unsigned threads_;
  std::vector<int32_t> ground_, lowest_, highest_;  // at the last epoch; over all so far
  std::vector<proto::QuantisedError> least_errors_;
  std::vector<NodeRecord> scratch_;
  proto::LatticeWindow moved_;  // hull of all epochs' so far
  EpochSection section_;
  std::vector<EpochReport> reports_;
};

}  // namespace foreland::terrain
