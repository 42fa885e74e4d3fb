#include "server/occlusion/objects/viewer_objects.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <utility>

namespace foreland::server {

namespace {

constexpr double kLargeEnough_px = 12;  // across, of an object that is likely to be refined
constexpr int64_t kRest = 2;            // intervals that what has turned visible stays so at least

// Spreads what is done now and then over the keyframes.
uint32_t phaseOf(size_t object) { return static_cast<uint32_t>(object * 2654435761u >> 7); }

}  // namespace

bool hideFrom(const ObjectSolids& solids, const EyeCapsule& eyes, std::span<const glm::dvec3> target, double rho_m,
              uint32_t& hint, uint64_t& queries) {
  const double length = glm::length(eyes.way) + 2 * eyes.radius_m;
  const auto pieces = static_cast<uint32_t>(std::clamp(std::ceil(length / ViewerObjects::kMaxPiece_m), 1.0, 32.0));
  for (uint32_t i = 0; i < pieces; ++i) {
    const EyeCapsule piece{eyes.eye + eyes.way * (static_cast<double>(i) / pieces),
                           eyes.way / static_cast<double>(pieces), eyes.radius_m};
    ++queries;
    const uint32_t found = solids.hiding(piece, target, rho_m, hint);
    if (found == ObjectSolids::kNone) return false;
    hint = found;
  }
  return true;
}

void ViewerObjects::begin(Keyframe keyframe) {
  now_.emplace(std::move(keyframe));
  last_query_ = queries_ + kMaxQueries;
  hidden_in_view_ = 0;
}

void ViewerObjects::forget() { states_.assign(states_.size(), {}); }

bool ViewerObjects::isWorth(size_t object, size_t nodes) const {
  if (nodes > 0) return nodes >= kFewestNodes;
  const ObjectBall& ball = objects_.balls[object];
  const double distance = glm::distance(ball.middle, now_->view.pose.eye);
  return 2 * ball.radius_m * now_->view.lens.focalPx() > kLargeEnough_px * distance;
}

bool ViewerObjects::hides(size_t object, State& state, PathSpan& span, Towards towards) {
  if (queries_ >= last_query_) return false;
  const auto& corners = solids_.cornersOf(object);
  if (now_->behind_ridge && now_->behind_ridge(span, corners, towards)) return true;
  return hideFrom(solids_, span.eyes, corners, 0, state.hint, queries_);
}

// Out of view it makes no difference whether an object is hidden, and need not be tried before it comes into view.
bool ViewerObjects::isHidden(size_t object, size_t nodes) {
  State& state = states_[object];
  const auto last = static_cast<int32_t>(now_->intervals.last());
  if (!objects_.mayBeSeen(object, now_->view, now_->frustum)) {
    state.next = std::min(state.next, last);
    return state.is_hidden;
  }
  const auto test = [&](PathSpan& span, Towards towards) { return hides(object, state, span, towards); };
  const SpanProver& prover = now_->prover;
  if (state.is_hidden) {
    const bool stays = !(now_->has_faded && now_->has_faded(object)) &&
                       prover.staysHidden(state.proof, state.next, phaseOf(object), test);
    if (!stays) state.next = last + static_cast<int32_t>(kRest);
    state.is_hidden = stays;
  } else if (!now_->has_faded && state.next <= last && isWorth(object, nodes)) {
    state.is_hidden = prover.turnsHidden(state.proof, state.next, phaseOf(object), test);
  }
  hidden_in_view_ += state.is_hidden ? 1 : 0;
  return state.is_hidden;
}

}  // namespace foreland::server
