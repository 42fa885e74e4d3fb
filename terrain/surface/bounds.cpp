#include "terrain/surface/bounds.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <glm/geometric.hpp>
#include <numbers>

#include "terrain/parallel.h"
#include "terrain/surface/full_mesh.h"
#include "terrain/surface/support.h"

namespace foreland::terrain {

namespace {

using proto::NodeId;
using proto::Slot;
using proto::SurfaceRecord;

// Bound of the sum of any subset of displacements, by direction about an axis.
struct AnyOf {
  double outward = 0, inward = 0, across = 0;

  static AnyOf one(const glm::dvec3& d, const glm::dvec3& axis) {
    const double along = glm::dot(d, axis);
    return {std::max(along, 0.0), std::max(-along, 0.0), glm::length(d - along * axis)};
  }
  AnyOf operator+(const AnyOf& o) const { return {outward + o.outward, inward + o.inward, across + o.across}; }
  AnyOf operator*(double f) const { return {outward * f, inward * f, across * f}; }
  Extent extent(const glm::dvec3&) const { return {std::max(outward, inward), across}; }
};

// The sum of all displacements.
struct AllOf {
  glm::dvec3 sum{0};

  static AllOf one(const glm::dvec3& d, const glm::dvec3&) { return {d}; }
  AllOf operator+(const AllOf& o) const { return {sum + o.sum}; }
  AllOf operator*(double f) const { return {sum * f}; }
  Extent extent(const glm::dvec3& axis) const {
    const double along = glm::dot(sum, axis);
    return {std::fabs(along), glm::length(sum - along * axis)};
  }
};

// Bounds of one node while they are gathered.
struct Gathered {
  glm::dvec3 position, normal;  // the normal as its record will have it
  double radius = 0, bulge = 0, min_cosine = 1, cone_rad = 0;
  std::vector<Extent> errors;
};

class BoundsPass {
 public:
  BoundsPass(const TrueSurface& surface, const SurfaceBoundsJob& job)
      : surface_(surface), mesh_(surface.topology), full_(surface), job_(job), records_(mesh_.slotCount()) {
    addPose(surface);
    for (const SurfacePose& pose : surface.poses) {
      moved_.push_back({mesh_, surface.quantum_m, pose.base, pose.nodes});
      addPose(moved_.back());
    }
  }

  std::vector<SurfaceRecord> run() {
    constexpr uint32_t kChunk = 256;
    for (int level = mesh_.maxLevel(); level >= 1; --level) {
      const Slot first = mesh_.levelOffset(level), end = mesh_.levelOffset(level + 1);
      std::vector<Gathered> scratch(threadCount(job_.threads));
      const auto work = [&](uint64_t chunk, unsigned worker) {
        const auto from = static_cast<Slot>(first + chunk * kChunk);
        for (Slot slot = from; slot < std::min<uint64_t>(end, uint64_t{from} + kChunk); ++slot)
          if (const NodeId n = mesh_.node(slot); !mesh_.isBase(n)) records_[slot] = bound(n, slot, scratch[worker]);
      };
      const double done = mesh_.maxLevel() - level, levels = mesh_.maxLevel();
      const uint64_t chunks = (uint64_t{end} - first + kChunk - 1) / kChunk;
      const auto between = [&](uint64_t ready) {
        return job_.onProgress((done + static_cast<double>(ready) / static_cast<double>(chunks)) / levels);
      };
      if (!parallelFor(chunks, job_.threads, work, between)) return {};
    }
    return std::move(records_);
  }

 private:
  SurfaceRecord bound(NodeId n, Slot slot, Gathered& all) const {
    SurfaceRecord record;
    record.position = surface_.nodes[slot];
    record.normal = proto::CompactNormal::pack(full_.normalAt(full_.vertex(n)));
    all.position = full_.position(full_.vertex(n));
    all.normal = record.normal.unpack();
    all.radius = all.bulge = 0;
    all.min_cosine = 1;
    all.errors.clear();
    if (mesh_.rule() == proto::MeshRule::kQuadrisection)
      gatherAll<AnyOf>(n, all);
    else
      gatherAll<AllOf>(n, all);
    all.cone_rad = std::acos(std::clamp(all.min_cosine, -1.0, 1.0)) + kPad_rad;
    if (!surface_.poses.empty()) all.cone_rad = kAnyAngle_rad;
    for (NodeId child : mesh_.children(n)) includeSphereAndCone(records_[mesh_.slot(child)], all);
    const Extent error = errorShape(n, all);
    record.radius = proto::CompactBound::roundUp(all.radius + pad_m_);
    record.cone_sine = proto::CompactShare::roundUp(all.cone_rad < kRightAngle_rad ? std::sin(all.cone_rad) : 1);
    const bool is_posed = !surface_.poses.empty();
    record.bulge = proto::CompactShare::roundUp(is_posed ? 1 : (all.bulge + pad_m_) / record.radius.metres());
    record.error_along = proto::CompactBound::roundUp(error.along);
    record.error_across = proto::CompactBound::roundUp(error.across);
    return record;
  }

  void addPose(const TrueSurface& pose) {
    std::vector<glm::dvec3>& displacements = displacements_.emplace_back(mesh_.slotCount());
    double reach = 0;
    forEachNode(mesh_, [&](NodeId n, Slot slot) {
      const auto [a, b] = mesh_.endpoints(n);
      displacements[slot] = pose.position(n) - 0.5 * (pose.position(a) + pose.position(b));
    });
    for (uint32_t v = 0; v < mesh_.baseVertexCount(); ++v)
      reach = std::max(reach, glm::length(pose.position(proto::baseVertexId(v))));
    pad_m_ = std::max(pad_m_, 1e-6 * std::max(reach, pose.quantum_m));
  }

  template <class Missing>
  void gatherAll(NodeId n, Gathered& all) const {
    gather<Missing>(n, all);
    for (size_t pose = 1; pose < displacements_.size(); ++pose) gatherPose<Missing>(n, pose, all);
  }
  // Spheres and errors in another pose.
  template <class Missing>
  void gatherPose(NodeId n, size_t pose, Gathered& all) const {
    const TrueSurface& moved = moved_[pose - 1];
    const auto coefficient = [&](NodeId m) { return Missing::one(displacements_[pose][mesh_.slot(m)], all.normal); };
    const auto visit = [&](NodeId v, const Missing& missing) {
      const Extent error = missing.extent(all.normal);
      all.errors.push_back(error);
      const double drawn = std::hypot(error.along, error.across);
      for (uint32_t t : full_.trianglesAt(full_.vertex(v)))
        for (uint32_t corner : full_.triangles()[t])
          all.radius = std::max(all.radius, glm::length(positionOf(moved, corner) - all.position) + drawn);
    };
    SupportWalk<Missing, decltype(coefficient), decltype(visit)>(mesh_, coefficient, visit).run(n);
  }
  // By number in the full mesh.
  glm::dvec3 positionOf(const TrueSurface& pose, uint32_t vertex) const {
    const uint32_t base = mesh_.baseVertexCount();
    return glm::dvec3(vertex < base ? pose.base[vertex] : pose.nodes[vertex - base]) * pose.quantum_m;
  }

  template <class Missing>
  void gather(NodeId n, Gathered& all) const {
    const auto coefficient = [&](NodeId m) { return Missing::one(displacements_[0][mesh_.slot(m)], all.normal); };
    const auto visit = [&](NodeId v, const Missing& missing) {
      const size_t vertex = full_.vertex(v);
      const Extent error = missing.extent(all.normal);
      all.errors.push_back(error);
      const double drawn = std::hypot(error.along, error.across);
      for (uint32_t t : full_.trianglesAt(vertex)) {
        for (uint32_t corner : full_.triangles()[t])
          all.radius = std::max(all.radius, glm::length(full_.position(corner) - all.position) + drawn);
        const glm::dvec3& normal = full_.normal(t);
        if (normal == glm::dvec3(0)) continue;
        all.min_cosine = std::min(all.min_cosine, glm::dot(normal, all.normal));
        all.bulge = std::max(all.bulge, std::fabs(glm::dot(normal, full_.position(vertex) - all.position)));
      }
    };
    SupportWalk<Missing, decltype(coefficient), decltype(visit)>(mesh_, coefficient, visit).run(n);
  }

  void includeSphereAndCone(const SurfaceRecord& child, Gathered& all) const {
    const glm::dvec3 aside = glm::dvec3(child.position) * surface_.quantum_m - all.position,
                     normal = child.normal.unpack();
    const double distance = glm::length(aside), radius = child.radius.metres();
    all.radius = std::max(all.radius, distance + radius);
    if (child.cone_sine.isFull()) {
      all.cone_rad = kAnyAngle_rad;
      return;
    }
    const double half_angle = std::asin(child.cone_sine.value());
    const double between = std::acos(std::clamp(glm::dot(normal, all.normal), -1.0, 1.0));
    all.cone_rad = std::max(all.cone_rad, half_angle + between + kPad_rad);
    // Largest |m . aside| over the normals m of the child's cone.
    const double up = std::fabs(glm::dot(normal, aside)),
                 flat = std::sqrt(std::max(0.0, distance * distance - up * up));
    const double tilted = std::min(distance, up * std::cos(half_angle) + flat * child.cone_sine.value());
    all.bulge = std::max(all.bulge, tilted + child.bulge.value() * radius);
  }

  // Fitted to the gathered errors and to points on the outlines of the children's shapes, then grown to contain these
  // wholly.
  Extent errorShape(NodeId n, Gathered& all) const {
    const auto children = mesh_.children(n);
    const auto shapeOf = [&](NodeId child) -> Extent {
      const SurfaceRecord& r = records_[mesh_.slot(child)];
      return {r.error_along.metres(), r.error_across.metres()};
    };
    const auto normalOf = [&](NodeId child) { return records_[mesh_.slot(child)].normal.unpack(); };
    for (NodeId child : children)
      addOutline(job_.shape, shapeOf(child), glm::dot(normalOf(child), all.normal),
                 glm::length(glm::cross(normalOf(child), all.normal)), all.errors);
    const Extent shape = job_.fit == ErrorFit::kSmallest ? boundingShape(job_.shape, all.errors)
                                                         : boundingShapeByLargest(job_.shape, all.errors);
    double growth = 1;
    for (NodeId child : children)
      growth = std::max(growth, growthToHold(job_.shape, shape, all.normal, shapeOf(child), normalOf(child)));
    growth *= 1 + 1e-9;
    return {shape.along * growth, shape.across * growth};
  }

  static constexpr double kPad_rad = 1e-6, kRightAngle_rad = std::numbers::pi / 2, kAnyAngle_rad = 4;

  const TrueSurface& surface_;
  const proto::MeshTopology& mesh_;
  const FullMesh full_;
  const SurfaceBoundsJob& job_;
  double pad_m_ = 0;
  std::vector<TrueSurface> moved_;                      // the poses but the first
  std::vector<std::vector<glm::dvec3>> displacements_;  // by pose
  std::vector<SurfaceRecord> records_;
};

}  // namespace

std::vector<SurfaceRecord> computeBounds(const TrueSurface& surface, const SurfaceBoundsJob& job) {
  return BoundsPass(surface, job).run();
}

}  // namespace foreland::terrain
