#include "client/timeline.h"

#include <algorithm>

#include "base/latency.h"

namespace foreland::client {

namespace {

constexpr size_t kRecent = 16;
constexpr Duration kLatencyMargin = Duration::milliseconds(10);
// Longer ones come of clocks that were set anew.
constexpr Duration kLongestPlayoutDelay = Duration::seconds(10);
constexpr Duration kPlayoutDelayFall = Duration::milliseconds(2);  // at most, per keyframe

// A section that is shown as soon as it is there. What was computed for a later time, by a time stamp that was wrong,
// cannot be waited for.
bool startsAnew(const MeshPatch& mesh) { return mesh.from.index == mesh.to.index || mesh.to.time < mesh.from.time; }

// The server sends a section coarse so that it is there at once, and what is missing after it.
bool refines(const Interval& shown, const MeshPatch& mesh, Duration shortest) {
  return shown.from.index == shown.to.index && mesh.from.index == shown.to.index && mesh.to.tau_px < mesh.from.tau_px &&
         mesh.to.time - mesh.from.time < shortest;
}

// Of n + 1 keyframes the last one must be there (n + 1) / 2 intervals before what is in the middle of them is shown.
Duration leadTime(const EarlierKeyframes& earlier, Duration interval) {
  return interval + Duration{interval.us * earlier.count / 2};
}

}  // namespace

Duration Timeline::intervalOf(const MeshPatch& mesh) {
  const Duration interval = mesh.to.time - mesh.from.time;
  if (startsAnew(mesh)) return std::max(interval, interval_.longest);
  if (intervals_.empty()) intervals_.push_back(interval_.shortest);
  intervals_.push_back(interval);
  if (intervals_.size() > kRecent) intervals_.pop_front();
  const Duration least = *std::min_element(intervals_.begin(), intervals_.end());
  return std::max({least, std::min(interval, least + kLongestDelay - playoutExcess()), interval_.longest});
}

// Of the playout delay, what it has beyond the least recent latency.
Duration Timeline::playoutExcess() const {
  if (latencies_.empty()) return {};
  const Duration least = std::max(Duration{}, *std::min_element(latencies_.begin(), latencies_.end()) + kLatencyMargin);
  return std::max(Duration{}, playout_delay_ - least);
}

// The playout delay is the worst recent latency, outages apart, and a margin. It falls slowly, so that t_d does not
// jump when the link gets better.
void Timeline::updatePlayoutDelay(const MeshPatch& mesh, Time arrival) {
  latencies_.push_back(arrival - mesh.to.time);
  if (latencies_.size() > kRecent) latencies_.pop_front();
  const Duration wanted = std::max(Duration{}, slowestUsual(latencies_) + kLatencyMargin);
  playout_delay_ = std::min(std::max(wanted, playout_delay_ - kPlayoutDelayFall), kLongestPlayoutDelay);
}

// What is shown jumps anyway, so nothing is owed to how late it was before.
void Timeline::restart() {
  schedule_.clear();
  meshes_.clear();
  intervals_.clear();
  latencies_.clear();
  playout_delay_ = {};
}

void Timeline::push(std::shared_ptr<const MeshPatch> mesh, Time begin, Time end) {
  schedule_.add({next_version_++, begin, end, mesh->from, mesh->to, mesh->earlier});
  meshes_.push_back(std::move(mesh));
}

Duration Timeline::add(std::shared_ptr<const MeshPatch> mesh, Time arrival, proto::Strategy strategy) {
  const bool still = startsAnew(*mesh), predicted = strategy == proto::Strategy::kPredict;
  if (still) restart();
  const bool first = meshes_.empty();
  const bool refining = !first && !still && refines(schedule_.back(), *mesh, interval_.shortest);
  const Duration playout_delay_before = playout_delay_;
  if (predicted) {
    latencies_.clear();
    playout_delay_ = {};
  } else {
    updatePlayoutDelay(*mesh, arrival);
  }
  const Duration lead = leadTime(mesh->earlier, refining ? interval_.most() : intervalOf(*mesh));
  const Time shown_from = mesh->from.time - mesh->earlier.from_age, shown_to = mesh->to.time - mesh->earlier.to_age;
  // Late by the playout delay in force before this arrival, which is what the viewer was shown by.
  const Duration lateness = arrival - (shown_from + (predicted ? Duration{} : lead + playout_delay_before));
  const Duration delay = predicted ? Duration{} : lead + playout_delay_;
  Time begin = std::max(arrival, shown_from + delay);
  if (first || refining)
    begin = arrival;
  else
    begin = std::max(begin, schedule_.back().end);
  const Time soonest = begin + kShortestBlend;
  const Time end = first ? begin : refining && !predicted ? soonest : std::max(shown_to + delay, soonest);
  push(std::move(mesh), begin, end);
  ++undrawn_;
  while (meshes_.size() > (undrawn_ > kMaxUndrawn ? kMaxUndrawn : kMaxMeshes)) {
    meshes_.pop_front();
    schedule_.popFront();
  }
  return still || first || refining ? Duration{} : lateness;
}

void Timeline::extend(std::shared_ptr<const MeshPatch> mesh) {
  const Time begin = schedule_.back().end;
  push(std::move(mesh), begin, begin + kExtension);
}

Timeline::Shown Timeline::at(Time now) {
  undrawn_ = 0;
  Shown shown{schedule_.at(now)};
  while (meshes_.size() > schedule_.size()) meshes_.pop_front();
  if (shown.interval) shown.mesh = meshes_.front().get(), shown.version = shown.interval->version;
  return shown;
}

}  // namespace foreland::client
