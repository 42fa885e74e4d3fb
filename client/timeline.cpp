#include "client/timeline.h"

#include <algorithm>

namespace foreland::client {

namespace {

constexpr size_t kLatencies = 16;
constexpr Duration kLatencyMargin = Duration::milliseconds(10);

}  // namespace

// lambda is the worst recent latency beyond the keyframe's own time.
void Timeline::updateDelay(const KeyframeMesh& mesh, Time arrival, proto::Strategy strategy) {
  if (strategy == proto::Strategy::kPredict) {
    delay_ = {};
    latencies_.clear();
    return;
  }
  latencies_.push_back(arrival - mesh.to.time);
  if (latencies_.size() > kLatencies) latencies_.pop_front();
  const Duration lambda = std::max(Duration{}, *std::max_element(latencies_.begin(), latencies_.end()) + kLatencyMargin);
  // Never below the last value by more than a little, so that t_d glides when the link gets better.
  const Duration wanted = (mesh.to.time - mesh.from.time) + lambda;
  delay_ = std::max(wanted, delay_ - Duration::milliseconds(2));
}

Duration Timeline::add(std::shared_ptr<const KeyframeMesh> mesh, Time arrival, proto::Strategy strategy) {
  const bool first = entries_.empty();
  const Duration previous_delay = delay_;
  updateDelay(*mesh, arrival, strategy);
  // Judged by the delay in force when it was awaited; a still mesh is awaited by nobody.
  const Duration judged = strategy == proto::Strategy::kPredict ? Duration{} : std::max(previous_delay, mesh->to.time - mesh->from.time);
  const Duration lateness = arrival - (mesh->from.time + judged);
  Time begin = std::max(arrival, mesh->from.time + delay_);
  if (first) begin = arrival;
  else begin = std::max(begin, entries_.back().end);
  const Time end = first ? begin : std::max(mesh->to.time + delay_, begin + kShortestBlend);
  const bool still = mesh->from.index == mesh->to.index;
  entries_.push_back({std::move(mesh), begin, end, next_version_++});
  // A host that has stopped drawing keeps the newest few; each is whole in itself.
  if (entries_.size() > kMaxMeshes) entries_.pop_front();
  return still || first ? Duration{} : lateness;
}

Timeline::Shown Timeline::at(Time now) {
  if (entries_.empty()) return {};
  while (entries_.size() > 1 && now >= entries_[1].begin) entries_.pop_front();
  const Entry& e = entries_.front();
  const double span = static_cast<double>((e.end - e.begin).us);
  const double weight = span <= 0 ? 1.0 : std::clamp(static_cast<double>((now - e.begin).us) / span, 0.0, 1.0);
  const Duration covered = e.mesh->to.time - e.mesh->from.time;
  const Time scene = e.mesh->from.time + Duration{static_cast<int64_t>(weight * static_cast<double>(covered.us))};
  return {e.mesh.get(), weight, scene, e.version};
}

}  // namespace foreland::client
