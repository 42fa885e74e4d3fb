#include "server/view/tour_plans.h"

#include <algorithm>
#include <utility>

#include "server/view/tour.h"

namespace foreland::server {

std::shared_ptr<const proto::Path> TourPlans::find(const std::string& name, double seconds, Time now) {
  const std::lock_guard lock(mutex_);
  if (scene_.supply() != nullptr)
    std::erase_if(plans_, [&](const Plan& plan) { return now > plan.made_at + kLasting; });
  const auto at =
      std::ranges::find_if(plans_, [&](const Plan& plan) { return plan.name == name && plan.seconds == seconds; });
  return at == plans_.end() ? nullptr : at->path;
}

// Who asks while another worker plans the same tour plans it, too, rather than wait.
std::shared_ptr<const proto::Path> TourPlans::plan(const std::string& name, double seconds, Time now) {
  if (auto known = find(name, seconds, now)) return known;
  auto path = std::make_shared<const proto::Path>(planTour(scene_, name, seconds).value());
  if (seconds > kLongest_s) return path;
  const std::lock_guard lock(mutex_);
  plans_.push_front({name, seconds, now, path});
  if (plans_.size() > kMost) plans_.pop_back();
  return path;
}

}  // namespace foreland::server
