#include "server/section/ground_motion.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <limits>

#include "proto/refine/metric/metric.h"

namespace foreland::server {

namespace {

constexpr uint32_t kMaxSquares = 64;  // of ground, a side
constexpr uint32_t kMinSide = 4;      // samples
constexpr double kMax = std::numeric_limits<float>::max();
constexpr double kRoundUp = 1 + 1e-6;  // of floats, and of a limit that is found up to rounding

// Calls visit(position in the first pose, moves) for all vertices of the object's model.
template <class Visit>
void forEachVertex(const SceneObjects& objects, size_t object, const Visit& visit) {
  const proto::ObjectModel& model = objects.set.modelOf(object);
  const proto::ModelNodes& nodes = objects.nodesOf(object);
  for (size_t v = 0; v < model.base.size(); ++v)
    visit(model.base[v], std::span(model.base_moves).subspan(v * nodes.moves_each, nodes.moves_each));
  for (proto::Slot slot = 0; slot < nodes.records.size(); ++slot)
    visit(nodes.records[slot].position, nodes.movesOf(slot));
}

}  // namespace

GroundMotion::GroundMotion(const Hierarchy& hierarchy) : hierarchy_(hierarchy) {
  const proto::Epochs& epochs = hierarchy.epochs().epochs();
  for (uint32_t i = 0; i + 1 < epochs.size(); ++i) curves_.push_back(epochs.curveAfter(i));
  const proto::GridShape& shape = hierarchy.grid().shape();
  side_ = std::max(kMinSide, (std::max(shape.samples_x, shape.samples_y) - 1) / kMaxSquares + 1);
  columns_ = (shape.samples_x - 1) / side_ + 1;
  movers_.resize(size_t{columns_} * ((shape.samples_y - 1) / side_ + 1));
  hierarchy.epochs().forEachMoving(hierarchy.grid(),
                                   [&](proto::NodeId v, std::span<const int32_t> quanta) { add(v, quanta); });
  addObjects();
  std::erase_if(movers_, [](const Mover& mover) { return mover.acceleration.empty(); });
}

GroundMotion::Mover& GroundMotion::moverOf(proto::NodeId v) {
  const proto::GridShape& shape = hierarchy_.grid().shape();
  const uint32_t x = std::min(v.x(), shape.samples_x - 1) / side_, y = std::min(v.y(), shape.samples_y - 1) / side_;
  Mover& mover = movers_[size_t{y} * columns_ + x];
  if (mover.acceleration.empty()) mover.centre = hierarchy_.frame().position(v, hierarchy_.scene().height(v));
  return mover;
}

void GroundMotion::add(proto::NodeId v, std::span<const int32_t> quanta) {
  if (std::ranges::all_of(quanta, [](int32_t q) { return q == 0; })) return;
  Mover& mover = moverOf(v);
  for (const double risen : hierarchy_.epochs().epochs().range(quanta))
    mover.radius_m =
        std::max(mover.radius_m,
                 glm::distance(mover.centre, hierarchy_.frame().position(v, hierarchy_.scene().height(v) + risen)));
  raise(mover, quanta, 0);
}

// `quanta` by epoch, each off by `off_quanta` at most.
void GroundMotion::raise(Mover& mover, std::span<const int32_t> quanta, double off_quanta) const {
  const proto::Epochs& epochs = hierarchy_.epochs().epochs();
  mover.acceleration.resize(curves_.size());
  for (size_t i = 0; i < curves_.size(); ++i) {
    const double seconds = (epochs[i + 1].time - epochs[i].time).toSeconds();
    for (const auto& weights : curves_[i].accelerations()) {
      double sum = 0, off = 0;
      for (uint32_t k = 0; k < curves_[i].count; ++k) {
        sum += weights[k] * quanta[curves_[i].first + k];
        off += std::fabs(weights[k]) * off_quanta;
      }
      const double most = (std::fabs(sum) + off) * hierarchy_.scene().frame().height_quantum_m / (seconds * seconds);
      mover.acceleration[i] = std::max(mover.acceleration[i], static_cast<float>(std::min(kRoundUp * most, kMax)));
    }
  }
}

// An object's rises are rounded to quanta, in truth they may be half of one off.
void GroundMotion::addObjects() {
  const SceneObjects& objects = hierarchy_.objects();
  for (size_t i = 0; i < objects.set.size(); ++i) {
    const proto::ObjectPlacement& p = objects.set.placement(i);
    if (p.rise.isStill() && objects.set.posesOf(i).isStill()) continue;
    Mover mover{p.position, 0, std::vector<float>(curves_.size())};
    forEachVertex(objects, i, [&](const glm::ivec3& position, std::span<const glm::ivec3> moves) {
      mover.radius_m = std::max(mover.radius_m, glm::length(glm::dvec3(position)));
      for (const glm::ivec3& move : moves)
        mover.radius_m = std::max(mover.radius_m, glm::length(glm::dvec3(position) + glm::dvec3(move)));
    });
    mover.radius_m *= objects.set.modelOf(i).quantum_m * p.scale;
    mover.radius_m += std::max(-p.rise.range[0], p.rise.range[1]) * glm::length(p.rise.quantum);
    if (!p.rise.isStill()) raise(mover, p.rise.quanta, 0.5);
    if (!objects.set.posesOf(i).isStill()) addPoses(mover, i);
    movers_.push_back(std::move(mover));
  }
}

// Accelerates by the most that the object's own motion does, beside that of what carries it.
void GroundMotion::addPoses(Mover& mover, size_t object) const {
  const proto::Epochs& epochs = hierarchy_.epochs().epochs();
  const SceneObjects& objects = hierarchy_.objects();
  std::vector<std::vector<double>> weights;  // of the poses, by epoch
  for (uint32_t epoch = 0; epoch < epochs.size(); ++epoch)
    weights.push_back(objects.set.posesOf(object).weightsAt({.epoch = {epoch}}));
  const double metres = objects.set.modelOf(object).quantum_m * objects.set.placement(object).scale;
  for (size_t i = 0; i < curves_.size(); ++i) {
    const double seconds = (epochs[i + 1].time - epochs[i].time).toSeconds();
    double most = 0;
    for (const auto& acceleration : curves_[i].accelerations())
      forEachVertex(objects, object, [&](const glm::ivec3&, std::span<const glm::ivec3> moves) {
        glm::dvec3 sum(0);
        for (uint32_t k = 0; k < curves_[i].count; ++k)
          sum += acceleration[k] * proto::posed(glm::ivec3(0), moves, weights[curves_[i].first + k]);
        most = std::max(most, glm::length(sum));
      });
    const double all = kRoundUp * (double{mover.acceleration[i]} + most * metres / (seconds * seconds));
    mover.acceleration[i] = static_cast<float>(std::min(all, kMax));
  }
}

std::vector<double> GroundMotion::longestSteps(const proto::View& view) const {
  const bool is_planar = hierarchy_.scene().frame().kind == proto::FrameKind::kPlanar;
  proto::View share = view;
  share.tau_px *= proto::kMotionShare;
  const proto::Metric metric(share, is_planar);
  std::vector<double> steps_s(curves_.size(), std::numeric_limits<double>::infinity());
  for (const Mover& mover : movers_) {
    const glm::dvec3 d = mover.centre - view.pose.eye;
    const double min_m =
        metric.minError({metric.frustum().toView(d.x, d.y, d.z), std::hypot(d.x, d.y)}, mover.radius_m) / kRoundUp;
    for (size_t i = 0; i < steps_s.size(); ++i)
      if (mover.acceleration[i] > 0)
        steps_s[i] = std::min(steps_s[i], std::sqrt(8 * min_m / double{mover.acceleration[i]}));
  }
  return steps_s;
}

Time GroundMotion::towards(Time from, Time wanted, const proto::View& view) const {
  const proto::Epochs& epochs = hierarchy_.epochs().epochs();
  if (from == wanted || curves_.empty()) return wanted;
  const std::vector<double> steps_s = longestSteps(view);
  const bool is_forwards = wanted > from;
  const double way_s = std::fabs((wanted - from).toSeconds());
  double reach_s = way_s;
  for (size_t k = 0; k < steps_s.size(); ++k) {
    const size_t i = is_forwards ? k : steps_s.size() - 1 - k;
    const Time begin = epochs[is_forwards ? i : i + 1].time, end = epochs[is_forwards ? i + 1 : i].time;
    if (is_forwards ? end <= from : end >= from) continue;
    // A way that enters this interval must be short enough for it; one may end where it begins.
    const double begin_s = is_forwards ? (begin - from).toSeconds() : (from - begin).toSeconds();
    if (begin_s >= reach_s) break;
    reach_s = std::max(begin_s, std::min(reach_s, steps_s[i]));
  }
  if (reach_s >= way_s) return wanted;
  const auto reach_us = std::max<int64_t>(1, static_cast<int64_t>(reach_s * 1e6));
  return from + Duration{is_forwards ? reach_us : -reach_us};
}

}  // namespace foreland::server
