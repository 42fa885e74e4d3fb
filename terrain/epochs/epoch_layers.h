// The ground of a scene epoch by epoch, all of it in memory: what the scene file says of each
// (store/tables/epoch_section.h), and what the bounds of nodes need in order to hold at all times (epoch_walk.h).
//
// One owner. Memory: that of an EpochWalk, and 9 bytes a slot. Cost: for each epoch, bounds of the rows around what it
// changes; with Catmull-Rom three times that.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "base/result.h"
#include "terrain/bounds/bounds.h"
#include "terrain/epochs/epoch_walk.h"
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
  EpochLayers(const proto::GridTopology& grid, const proto::Frame& frame, Heights first, const proto::Epochs& dates,
              EpochSection& section, unsigned threads);

  // The first epoch; then the others, in order. `keepGoing` as in BoundsJob::onProgress.
  Status begin(const EpochSamples& first);
  Status add(const EpochSamples& epoch, const std::function<bool(double)>& keepGoing);

  Heights lowest() const { return {walk_.lowest(), first_.width, first_.height}; }
  Heights highest() const { return {walk_.highest(), first_.width, first_.height}; }
  std::span<const proto::QuantisedError> minErrors() const { return min_errors_; }
  HeightRange range() const;
  const std::vector<EpochReport>& reports() const { return reports_; }

 private:
  Status raiseErrors(const GroundAtTime& ground, const std::function<bool(double)>& keepGoing);
  bool meets(proto::Slot slot, const proto::LatticeWindow& window) const;

  const proto::GridTopology& grid_;
  Heights first_;
  unsigned threads_;
  EpochWalk walk_;
  std::vector<proto::QuantisedError> min_errors_;
  std::vector<NodeRecord> scratch_;
  proto::LatticeWindow moved_;  // hull of all epochs' so far
  EpochSection& section_;
  std::vector<EpochReport> reports_;
};

}  // namespace foreland::terrain
