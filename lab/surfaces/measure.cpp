#include "lab/surfaces/measure.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <numbers>

#include "base/quantile.h"
#include "lab/surfaces/draw.h"
#include "oracle/surface/surface_truth.h"
#include "proto/refine/adapter.h"
#include "sim/thread_time.h"

namespace foreland::lab {

namespace {

struct Sphere {
  glm::dvec3 centre;
  double radius;
};

Sphere sphereAround(const terrain::TrueSurface& surface) {
  glm::dvec3 low(1e300), high(-1e300);
  const auto forEachPosition = [&](const auto& visit) {
    for (uint32_t v = 0; v < surface.topology.baseVertexCount(); ++v) visit(surface.position(proto::baseVertexId(v)));
    terrain::forEachNode(surface.topology, [&](proto::NodeId n, proto::Slot) { visit(surface.position(n)); });
  };
  forEachPosition([&](const glm::dvec3& p) { low = glm::min(low, p), high = glm::max(high, p); });
  Sphere sphere{0.5 * (low + high), 0};
  forEachPosition(
      [&](const glm::dvec3& p) { sphere.radius = std::max(sphere.radius, glm::length(p - sphere.centre)); });
  return sphere;
}

proto::Pose lookAt(const Sphere& sphere, const glm::dvec3& direction, double distance) {
  return {sphere.centre + direction * distance, proto::lookAlong(-direction, {0, 0, 1})};
}

// The distance from which a sphere covers this share of the screen's height.
double distanceFor(const Sphere& sphere, const proto::Lens& lens, double disc) {
  return sphere.radius / std::sin(std::atan(disc * std::tan(0.5 * lens.vertical_fov_rad)));
}

template <class Work>
double medianMilliseconds(const Work& work) {
  std::vector<double> times;
  for (int i = 0; i < 3; ++i) {
    const double begin = sim::threadSeconds();
    work();
    times.push_back(1e3 * (sim::threadSeconds() - begin));
  }
  return median(times);
}

}  // namespace

proto::Pose poseAtDisc(const terrain::TrueSurface& surface, const SurfaceSession& session, double disc,
                       const glm::dvec3& direction) {
  const Sphere sphere = sphereAround(surface);
  return lookAt(sphere, direction, distanceFor(sphere, session.lens, disc));
}

std::vector<proto::Pose> sessionPoses(const terrain::TrueSurface& surface, const SurfaceSession& session) {
  const Sphere sphere = sphereAround(surface);
  const double far = distanceFor(sphere, session.lens, session.disc), near = 1.15 * sphere.radius;
  const auto direction = [](double turns, double rise) {
    const double around = 2 * std::numbers::pi * turns;
    return glm::dvec3(std::cos(around) * std::cos(rise), std::sin(around) * std::cos(rise), std::sin(rise));
  };
  std::vector<proto::Pose> poses;
  for (uint32_t i = 0; i < session.turning_frames; ++i) {
    const double done = static_cast<double>(i) / session.turning_frames;
    poses.push_back(lookAt(sphere, direction(2 * done, 0.9 * std::cos(std::numbers::pi * done)), far));
  }
  for (uint32_t i = 0; i < session.zoom_frames; ++i) {
    const double done = (i + 1.0) / session.zoom_frames;
    poses.push_back(lookAt(sphere, direction(2, -0.9 + 0.6 * done), far * std::pow(near / far, done)));
  }
  return poses;
}

SurfaceBench::SurfaceBench(const terrain::TrueSurface& surface, proto::ErrorShape shape, terrain::ErrorFit fit)
    : surface_(surface),
      shape_(shape),
      full_(oracle::truthOf(surface)),
      oracle_(full_),
      nearest_m_(1e-3 * sphereAround(surface).radius) {
  const double begin = sim::threadSeconds();
  records_ = terrain::computeBounds(surface, {.shape = shape, .fit = fit, .threads = 1});
  bounds_seconds_ = sim::threadSeconds() - begin;
}

proto::SurfaceDomain SurfaceBench::domain(const SurfaceSession& session) const {
  return {.mesh = &surface_.topology,
          .quantum_m = surface_.quantum_m,
          .interior_per_tau = session.interior_px / session.silhouette_px,
          .nearest_m = nearest_m_,
          .is_closed = full_.is_closed,
          .shape = shape_};
}

oracle::PlainSection SurfaceBench::refine(const SurfaceSession& session, const proto::Pose& pose, double scale) const {
  return oracle::plainRefine(surface_, records_,
                             domain(session).metric({pose, session.lens, scale * session.silhouette_px}));
}

double SurfaceBench::adapt(const SurfaceSession& session, const proto::Pose& pose,
                           proto::SurfaceAdapter& adapter) const {
  proto::AdaptScratch scratch;
  proto::CutDelta delta;
  const double begin = sim::threadSeconds();
  CHECK_TRUE(adapter.adapt({pose, session.lens, session.silhouette_px}, surface_.topology.slotCount(), records_,
                           scratch, delta));
  const double ms = 1e3 * (sim::threadSeconds() - begin);
  const oracle::PlainSection expected = refine(session, pose, 1);
  CHECK_EQ(adapter.nodeCount(), expected.nodes);
  for (proto::Slot slot : adapter.section().slots) CHECK_TRUE(expected.active[slot] != 0);
  return ms;
}

FrameCost SurfaceBench::measure(const SurfaceSession& session, const proto::Pose& pose) const {
  FrameCost cost;
  oracle::PlainSection section;
  cost.refine_ms = medianMilliseconds([&] { section = refine(session, pose, 1); });
  DepthDrawing drawing(session.lens);
  cost.full_draw_ms = medianMilliseconds([&] { drawing.draw(full_.positions, full_.triangles, pose); });
  oracle::MeshToDraw mesh;
  cost.draw_ms = medianMilliseconds([&] {
    oracle::meshToDraw(surface_, section, mesh);
    drawing.draw(mesh.positions, mesh.triangles, pose);
  });
  const auto verdict = oracle_.judge(oracle::drawnTriangles(surface_, section), pose, session.lens, nearest_m_);
  cost.faces = mesh.triangles.size();
  cost.nodes = section.nodes;
  cost.silhouette_error_px = verdict.silhouette.max_px;
  cost.interior_error_px = verdict.interior.max_px;
  cost.uncovered = verdict.uncovered;
  return cost;
}

size_t SurfaceBench::faces(const SurfaceSession& session, const proto::Pose& pose, double scale) const {
  return oracle::countTriangles(surface_, refine(session, pose, scale));
}

double SurfaceBench::meanWorstShare(const SurfaceSession& session, const std::vector<proto::Pose>& poses,
                                    double scale) const {
  double sum = 0;
  for (const proto::Pose& pose : poses) {
    const auto verdict =
        oracle_.judge(oracle::drawnTriangles(surface_, refine(session, pose, scale)), pose, session.lens, nearest_m_);
    sum += std::max(verdict.silhouette.max_px / session.silhouette_px, verdict.interior.max_px / session.interior_px);
  }
  return sum / static_cast<double>(poses.size());
}

// By halving: the mean grows with the tolerances, but for small steps.
SurfaceBench::AtEqualError SurfaceBench::atEqualError(const SurfaceSession& session,
                                                      const std::vector<proto::Pose>& poses, double share) const {
  double low = 0.5, high = 4;
  for (int i = 0; i < 10; ++i) {
    const double middle = std::sqrt(low * high);
    (meanWorstShare(session, poses, middle) < share ? low : high) = middle;
  }
  AtEqualError result{std::sqrt(low * high), 0};
  for (const proto::Pose& pose : poses)
    result.faces += static_cast<double>(faces(session, pose, result.scale)) / static_cast<double>(poses.size());
  return result;
}

}  // namespace foreland::lab
