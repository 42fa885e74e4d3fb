// The tours of one scene that were planned of late, for all of its viewers: those who come together ask for the same
// ones, and planning one takes a worker longer than many keyframes. Any thread.
#pragma once

#include <deque>
#include <memory>
#include <mutex>
#include <string>

#include "base/time.h"
#include "proto/space/path.h"
#include "terrain/store/scene.h"

namespace foreland::server {

class TourPlans {
 public:
  static constexpr size_t kMost = 8;                           // plans that are kept, of 0.6 kB a second each
  static constexpr double kLongest_s = 600;                    // longer ones are not kept
  static constexpr Duration kLasting = Duration::seconds(10);  // over a scene at a distance, of which more comes

  // `scene` must outlive it.
  explicit TourPlans(const terrain::Scene& scene) : scene_(scene) {}

  // What planTour() returns for a tour that there is; at `now`, by the same clock each time.
  std::shared_ptr<const proto::Path> plan(const std::string& name, double seconds, Time now);

 private:
  struct Plan {
    std::string name;
    double seconds = 0;
    Time made_at;
    std::shared_ptr<const proto::Path> path;
  };
  std::shared_ptr<const proto::Path> find(const std::string& name, double seconds, Time now);

  const terrain::Scene& scene_;
  std::mutex mutex_;
  std::deque<Plan> plans_;  // the newest first
};

}  // namespace foreland::server
