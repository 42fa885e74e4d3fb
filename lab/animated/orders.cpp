#include "lab/animated/orders.h"

#include <algorithm>
#include <deque>
#include <glm/geometric.hpp>

#include "base/check.h"
#include "base/quantile.h"
#include "oracle/drawn_surface.h"
#include "oracle/oracle.h"
#include "oracle/surface/oracle_eye.h"

namespace foreland::lab {

namespace {

constexpr int kMaxOrder = 3;
constexpr size_t kWindow = 2 * kMaxOrder + 1;  // keyframes around a joint

// The weights of a window's keyframes, a keyframe before the joint at `first`.
std::vector<double> spread(const std::vector<double>& weights, size_t first) {
  std::vector<double> all(kWindow, 0);
  std::copy(weights.begin(), weights.end(), all.begin() + static_cast<std::ptrdiff_t>(first));
  return all;
}

// Positions and velocities at a joint in the middle of a window, as weights of its keyframes; velocities by intervals.
struct Joint {
  std::vector<double> position, before, after;

  Joint(oracle::Basis basis, int order) {
    const auto n = static_cast<size_t>(order);
    const bool is_spline = basis == oracle::Basis::kBSpline;
    // The window that ends at the joint, and the next one: a spline's moves on by one keyframe, a Bernstein curve's
    // begins where the other ended.
    const size_t first = kMaxOrder - n, second = is_spline ? first + 1 : kMaxOrder;
    const double scale = is_spline ? 1 : 1.0 / order;
    position = spread(oracle::basisWeights(basis, order, 1), first);
    before = spread(oracle::basisSlopes(basis, order, 1), first);
    after = spread(oracle::basisSlopes(basis, order, 0), second);
    for (auto* slopes : {&before, &after})
      for (double& slope : *slopes) slope *= scale;
  }
};

// A spline of order n shows the middle of its n + 1 keyframes.
double leadIntervals(oracle::Basis basis, int order) {
  return basis == oracle::Basis::kBSpline ? 0.5 * (order + 1) : order;
}

class Keyframes {
 public:
  Keyframes(const server::Hierarchy& hierarchy, std::span<const Time> scene_times)
      : hierarchy_(hierarchy),
        scene_times_(scene_times),
        offsets_(hierarchy.grid(), hierarchy.epochs().epochs(), hierarchy.epochs().baseOffsets()) {}

  void add(const proto::View& view, size_t index) {
    oracle::BlendedKeyframe keyframe;
    CHECK_TRUE(server::refine(hierarchy_, view, hierarchy_.grid().slotCount(), scratch_, keyframe.section));
    if (!scene_times_.empty()) keyframe.scene_time = scene_times_[index];
    window_.push_back(std::move(keyframe));
    if (window_.size() > kWindow) window_.pop_front();
    const oracle::BlendedKeyframe& newest = window_.back();
    for (const oracle::BlendedKeyframe& each : window_) {
      learn(each.section, newest.scene_time);
      learn(newest.section, each.scene_time);
    }
  }
  bool isFull() const { return window_.size() == kWindow; }
  oracle::OrderMesh mesh(const glm::dvec3& eye) const {
    const std::vector<oracle::BlendedKeyframe> keyframes(window_.begin(), window_.end());
    const terrain::Scene& scene = hierarchy_.scene();
    return oracle::blendSections(
        hierarchy_.domain(), {scene.cornerHeights(), scene.centreHeights()},
        [this](proto::Slot slot) { return hierarchy_.nodes()[slot]; }, scene_times_.empty() ? nullptr : &offsets_,
        keyframes, eye);
  }

 private:
  // The offsets of a section's nodes at a scene time.
  void learn(const proto::Section& section, Time scene_time) {
    const proto::Epochs& epochs = offsets_.epochs();
    if (epochs.empty()) return;
    const proto::EpochWeights weights = epochs.weightsAt(scene_time);
    for (uint32_t epoch : weights.epochs())
      for (proto::Slot slot : section.slots) {
        const proto::NodeId n = hierarchy_.grid().node(slot);
        if (!offsets_.knows(epoch, n)) offsets_.set(epoch, n, hierarchy_.epochs().offset(epoch, slot));
      }
  }

  const server::Hierarchy& hierarchy_;
  std::span<const Time> scene_times_;
  proto::EpochOffsets offsets_;
  proto::RefineScratch scratch_;
  std::deque<oracle::BlendedKeyframe> window_;
};

// Jumps of velocity at one joint, in pixels a second, seen by an eye at rest.
void judge(const oracle::OrderMesh& mesh, const std::vector<bool>& is_drawn, const Joint& joint,
           const oracle::OracleEye& eye, double interval_s, std::vector<double>& jumps_px_s) {
  constexpr double kMoment = 1e-6;  // intervals, over which a velocity is a distance
  for (size_t v = 0; v < mesh.parameters.size(); ++v) {
    const glm::dvec3 p = glm::dvec3(mesh.at(v, joint.position)) + mesh.origin;
    if (!is_drawn[v] || eye.depth(p) < oracle::Oracle::kDefaultNear_m || !eye.sees(eye.project(p))) continue;
    const glm::dvec3 before = kMoment * glm::dvec3(mesh.at(v, joint.before)),
                     after = kMoment * glm::dvec3(mesh.at(v, joint.after));
    jumps_px_s.push_back(glm::distance(eye.project(p + before), eye.project(p + after)) / (kMoment * interval_s));
  }
}

}  // namespace

std::vector<OrderFigures> measureOrders(const server::Hierarchy& hierarchy, std::span<const proto::View> views,
                                        std::span<const Time> scene_times, Duration interval) {
  std::vector<OrderFigures> figures;
  std::vector<Joint> joints;
  for (const oracle::Basis basis : {oracle::Basis::kBSpline, oracle::Basis::kBernstein})
    for (int order = 1; order <= kMaxOrder; ++order) {
      figures.push_back({.basis = basis, .order = order});
      figures.back().lead_ms = leadIntervals(basis, order) * interval.toMilliseconds();
      joints.emplace_back(basis, order);
    }
  std::vector<std::vector<double>> jumps_px_s(figures.size());
  Keyframes keyframes(hierarchy, scene_times);
  for (size_t k = 0; k < views.size(); ++k) {
    keyframes.add(views[k], k);
    if (!keyframes.isFull()) continue;
    const proto::View& at = views[k - kMaxOrder];
    const oracle::OrderMesh mesh = keyframes.mesh(at.pose.eye);
    const std::vector<bool> is_drawn = oracle::drawnVertices(mesh.parameters.size(), mesh.indices);
    for (size_t i = 0; i < figures.size(); ++i) {
      judge(mesh, is_drawn, joints[i], oracle::OracleEye(at.pose, at.lens), interval.toSeconds(), jumps_px_s[i]);
      ++figures[i].joints;
    }
  }
  for (size_t i = 0; i < figures.size(); ++i) {
    std::vector<double>& jumps = jumps_px_s[i];
    figures[i].vertices = jumps.size();
    if (jumps.empty()) continue;
    figures[i].velocity_jump_max_px_s = *std::max_element(jumps.begin(), jumps.end());
    figures[i].velocity_jump_p99_px_s = quantile(jumps, 0.99);
  }
  return figures;
}

}  // namespace foreland::lab
