#include "server/occlusion/horizon/globe_grids.h"

#include <pthread.h>
#include <sys/resource.h>

#include <algorithm>
#include <bit>
#include <glm/geometric.hpp>
#include <new>
#include <numbers>

namespace foreland::server {

namespace {

constexpr int kNice = 10;              // of the processors only what keyframes leave
constexpr double kMaxHeight = 0.5;     // of an eye above the zero surface, of the reach
constexpr double kPlaceOfReach = 0.5;  // the side of a place, at most
constexpr double kKeptWithin = 0.5;    // of the reach, from the middle
constexpr double kOfUseWithin = 1;     // the same, while there is no other

double distance(const HorizonGrid& grid, const glm::dvec3& eye) { return glm::length(glm::dvec2(grid.toAxes(eye))); }

}  // namespace

GlobeGrids::GlobeGrids(const Hierarchy& hierarchy, Building building)
    : hierarchy_(hierarchy), building_(building), reach_m_(globeHeightsReach(hierarchy.frame().transform().frame())) {
  const proto::Frame& frame = hierarchy.frame().transform().frame();
  // Steps are longest in the middle of a face.
  const double step_m = 0.5 * std::numbers::pi * frame.semi_major_m / frame.face_steps,
               steps = std::max(2.0, kPlaceOfReach * reach_m_ / step_m);
  side_log2_ = static_cast<uint32_t>(std::bit_width(static_cast<uint64_t>(steps))) - 1;
}

std::optional<GlobeGrids::Place> GlobeGrids::placeOf(const glm::dvec3& eye) const {
  constexpr double kMaxAbove_m = 1e5;  // where positions are still known (proto/space/frame.h)
  const proto::FrameTransform& transform = hierarchy_.frame().transform();
  const proto::Frame& frame = transform.frame();
  const double from_middle = glm::length(eye);
  if (!(from_middle < frame.semi_major_m + kMaxAbove_m && from_middle > 0.5 * frame.semiMinor())) return std::nullopt;
  const proto::LatticePosition at = transform.toLattice(eye);
  if (!(at.height_m < kMaxHeight * reach_m_)) return std::nullopt;
  const auto square = [&](double v, uint32_t most) {
    return static_cast<uint32_t>(std::clamp(v, 0.0, most - 1.0)) >> side_log2_;
  };
  return Place{square(at.x, hierarchy_.grid().maxX()), square(at.y, hierarchy_.grid().maxY())};
}

LocalPlane GlobeGrids::planeAt(const Place& place) const {
  const auto middle = [&](uint32_t v) { return (v << side_log2_) + (1u << (side_log2_ - 1)); };
  const glm::dvec3 origin = hierarchy_.frame().position(proto::NodeId::at(middle(place.x), middle(place.y)), 0);
  return LocalPlane::at(origin, hierarchy_.frame().transform().upAt(origin));
}

GlobeGrids::Grid GlobeGrids::about(const glm::dvec3& eye, const Grid& held) {
  const std::optional<Place> place = placeOf(eye);
  if (!place) return nullptr;
  if (held && distance(*held, eye) < kKeptWithin * reach_m_) return held;
  const Grid meanwhile = held && distance(*held, eye) < kOfUseWithin * reach_m_ ? held : nullptr;
  {
    const std::lock_guard lock(mutex_);
    if (const Grid known = find(*place)) return known;
    if (is_making_ || !makeRoom()) return meanwhile;
    is_making_ = true;
    if (building_ == Building::kOnAThread) {
      thread_ = std::jthread([this, place = *place](const std::stop_token& stop) {
        ::pthread_setname_np(::pthread_self(), "horizons");
        ::setpriority(PRIO_PROCESS, 0, kNice);  // of this thread, on Linux
        make(place, stop);
      });
      return meanwhile;
    }
  }
  make(*place, {});
  const std::lock_guard lock(mutex_);
  return find(*place);
}

GlobeGrids::Grid GlobeGrids::find(const Place& place) {
  const auto known = std::ranges::find(entries_, place, &Entry::place);
  if (known == entries_.end()) return nullptr;
  known->asked = ++asked_;
  return known->grid;
}

// What viewers hold stays, so there are never more.
bool GlobeGrids::makeRoom() {
  if (entries_.size() < kMost) return true;
  std::ranges::sort(entries_, {}, &Entry::asked);
  const auto unused = std::ranges::find_if(entries_, [](const Entry& entry) { return entry.grid.use_count() == 1; });
  if (unused == entries_.end()) return false;
  entries_.erase(unused);
  return true;
}

void GlobeGrids::make(const Place& place, const std::stop_token& stop) {
  Grid grid;
  try {
    if (const auto heights = globeHeights(hierarchy_, planeAt(place), stop))
      grid = std::make_shared<const HorizonGrid>(*heights);
  } catch (const std::bad_alloc&) {}  // the viewer goes on without
  const std::lock_guard lock(mutex_);
  if (grid) entries_.push_back({place, std::move(grid), ++asked_});
  is_making_ = false;
}

size_t GlobeGrids::bytes() const {
  const std::lock_guard lock(mutex_);
  size_t bytes = 0;
  for (const Entry& entry : entries_) bytes += entry.grid->bytes();
  return bytes;
}

}  // namespace foreland::server
