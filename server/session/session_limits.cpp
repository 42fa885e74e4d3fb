// How large a session's next section may be: what its viewer, the link and the server allow, and what a guessed region
// may add.

#include <algorithm>
#include <cmath>
#include <limits>

#include "server/session/session.h"

namespace foreland::server {

namespace {

// Where a viewer limits its bytes: what an added node costs, beyond which tolerance bytes count no more, and how long
// the first section may take on the link.
constexpr double kBitsOfNode = 10, kCoarsest_px = 200;
constexpr Duration kFirstThrough = Duration::seconds(1);
// Beyond so many times the wanted tolerance a section is better for less than its region.
constexpr double kUseless = 64;

// For the motion that is expected alone.
proto::View withoutErrors(proto::View view, const RegionParts& parts) {
  const Region region = parts.withoutErrors();
  view.region_radius_m = region.radius_m;
  view.region_angle_rad = region.angle_rad;
  return view;
}

}  // namespace

// That the viewer's frames are to keep, less what the ground's motion takes of it.
double Session::sectionTolerance() const {
  return proto::sectionTolerance(world_->hierarchy.epochs().epochs().blend(), input_.request().tau_px);
}

// A mesh has four triangles a root and two a node; the union of two sections is a little larger.
size_t Session::maxNodes() const {
  if (input_.request().max_triangles == 0) return options_.max_section_nodes;
  const proto::GridShape& shape = world_->hierarchy.grid().shape();
  const double nodes = 0.5 * (0.97 * input_.request().max_triangles - 4.0 * shape.roots_x * shape.roots_y);
  return std::min(options_.max_section_nodes, static_cast<size_t>(std::max(1.0, nodes)));
}

// How many nodes may be added before the delta takes the link longer than an interval, which would make this keyframe
// late, and the next ones.
double Session::maxAddedForLink() const {
  const Duration allowed = sender_.startsFromNothing() ? kFirstThrough : state_.interval;
  return 8.0 * input_.request().max_bytes_per_second * allowed.toSeconds() / kBitsOfNode;
}

// The share that the section of `view` takes of what viewer, link and server allow; infinite if it is not even
// measured whole.
double Session::loadOf(const proto::View& view, SessionScratch& scratch) {
  const size_t max_added = state_.has_jumped ? options_.max_added_after_jump : options_.max_added_nodes;
  // What starts from nothing is added whole, though what is remembered is not sent.
  const size_t most = sender_.startsFromNothing() ? std::min(maxNodes(), options_.max_added_nodes) : maxNodes();
  const SectionSize size = sender_.measure(view, most, scratch.send);
  statistics_.nodes_measured += size.nodes;
  if (!size.fits) return std::numeric_limits<double>::infinity();
  double load = std::max(double(size.nodes) / double(most), double(size.added) / double(max_added));
  if (input_.request().max_bytes_per_second > 0 && view.tau_px < kCoarsest_px)
    load = std::max(load, double(size.added) / maxAddedForLink());
  return load;
}

// Sets the tolerance that the viewer's budget allows, and a coarser one if the section, or what it adds, would still be
// too large for the viewer, the link, or one step of the server. One refinement tells, and is all that is done in most
// keyframes.
void Session::fitBudget(proto::View& view, SessionScratch& scratch) {
  const Budget budget{input_.request().max_triangles, input_.request().max_bytes_per_second, processors_};
  const double before_px = tolerance_.tolerance();
  const double coarser = isRegionGuessed() ? input_.motion().regionShare().coarser() : 1;
  // Falls as fast as what did not fit, once predictions are good again.
  const double wanted_px =
      static_cast<float>(std::max(tolerance_.next(sectionTolerance(), budget), coarser * sectionTolerance()));
  view.tau_px = wanted_px;
  if (budget.bytes_per_second == 0 && sender_.isLikelyToFit(view, maxNodes())) return tolerance_.force(wanted_px);
  const auto load = [&](double tau_px) {
    view.tau_px = tau_px;
    return loadOf(view, scratch);
  };
  view.tau_px = toleranceThatFits(wanted_px, before_px, load);
  if (view.tau_px > kUseless * wanted_px) {
    // Hardly anything can be guaranteed for a region that holds much of the scene, so this one does for its pose alone.
    view.region_radius_m = view.region_angle_rad = 0;
    view.tau_px = toleranceThatFits(wanted_px, before_px, load);
  }
  // A keyframe that starts from nothing may be coarse because it is to be there at once; the next one need not be.
  if (!sender_.startsFromNothing() || budget.triangles > 0 || budget.bytes_per_second > 0)
    tolerance_.force(view.tau_px);
}

// Along an announced path the region is no guess.
bool Session::isRegionGuessed() const { return state_.predicts && !input_.motion().isOnPath(input_.request()); }

// Before a keyframe: lets errors of predictions make its section no larger than they may (RegionShare). What starts
// from nothing is measured by fitBudget, and what a jump leaves unknown is not reduced.
void Session::fitRegion(proto::View view, const RegionParts& parts, SessionScratch& scratch) {
  if (!isRegionGuessed() || !input_.motion().isMotionKnown() || sender_.startsFromNothing()) return;
  view.tau_px = std::max(view.tau_px, tolerance_.tolerance());
  const proto::View without = withoutErrors(view, parts);
  std::optional<double> alone;  // as the first sample says; what errors add to it is told by each alone
  const auto nodesOf = [&](const Region& region, size_t most) -> std::optional<size_t> {
    view.region_radius_m = region.radius_m;
    view.region_angle_rad = region.angle_rad;
    const proto::SampledSize size = sender_.estimate(view, without, scratch.send);
    statistics_.nodes_measured += size.sample;
    if (!alone) alone = size.within;
    const auto nodes = static_cast<size_t>(std::llround(*alone * size.nodes / std::max(size.within, 1.0)));
    return nodes <= std::min(most, options_.max_section_nodes) ? std::optional(nodes) : std::nullopt;
  };
  input_.motion().regionShare().fit(parts, nodesOf);
}

// After a keyframe: how much errors made of its section.
void Session::observeRegion(const RegionParts& parts, SessionScratch& scratch) {
  if (!isRegionGuessed() || !input_.motion().regionShare().isDue(sender_.nodeCount())) return;
  const proto::SampledSize size = sender_.estimateWithin(withoutErrors(proto::viewOf(keyframe()), parts), scratch.send);
  statistics_.nodes_measured += size.sample;
  input_.motion().regionShare().observe(parts, sender_.nodeCount(), static_cast<size_t>(std::llround(size.within)));
}

}  // namespace foreland::server
