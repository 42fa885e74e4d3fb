// A model of a scene's objects at full resolution, for rays: its triangles in groups of kGroup that lie together.
// Immutable; any thread. Memory: twelve bytes a triangle.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <glm/vec3.hpp>
#include <span>
#include <vector>

#include "server/section/hierarchy.h"
#include "server/sight/box_tree.h"

namespace foreland::server {

class ObjectSurface {
 public:
  static constexpr uint32_t kGroup = 16;

  // `objects` must outlive it; one of them, at least, is of the model. O(triangles).
  ObjectSurface(const SceneObjects& objects, uint32_t model);

  uint32_t groups() const { return (triangles() + kGroup - 1) / kGroup; }
  // The model's frame, metres; of a group it holds all poses.
  Box boundsOf(uint32_t group) const;
  // From the model's origin to its farthest vertex, in any pose, along an axis; metres.
  double reachMetres() const { return reach_m_; }
  uint64_t bytes() const { return corners_.size() * sizeof(uint32_t); }

  // Calls visit(corners) for each triangle of a group, with positions in the model's frame, mixed from its poses by
  // `weights` (PoseBlend::weightsAt).
  template <class Visit>
  void forEachTriangleOf(uint32_t group, std::span<const double> weights, const Visit& visit) const {
    const uint32_t end = std::min(triangles(), (group + 1) * kGroup);
    for (uint32_t t = group * kGroup; t < end; ++t)
      visit(std::array{position(corners_[3 * size_t{t}], weights), position(corners_[3 * size_t{t} + 1], weights),
                       position(corners_[3 * size_t{t} + 2], weights)});
  }

 private:
  uint32_t triangles() const { return static_cast<uint32_t>(corners_.size() / 3); }
  std::span<const glm::ivec3> movesOf(uint32_t vertex) const;
  const glm::ivec3& quantaOf(uint32_t vertex) const {
    return vertex < base_ ? model_.base[vertex] : nodes_.records[vertex - base_].position;
  }
  glm::dvec3 position(uint32_t vertex, std::span<const double> weights) const {
    if (weights.empty()) return glm::dvec3(quantaOf(vertex)) * model_.quantum_m;
    return proto::posed(quantaOf(vertex), movesOf(vertex), weights) * model_.quantum_m;
  }

  const proto::ObjectModel& model_;
  const proto::ModelNodes& nodes_;
  uint32_t base_;  // vertices that precede the nodes
  double reach_m_ = 0;
  std::vector<uint32_t> corners_;  // base vertices by their number, then nodes by slot
};

}  // namespace foreland::server
