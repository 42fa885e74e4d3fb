// Interpolation of order n (P, theorem 1 and equation 1): frames blend n + 1 keyframes instead of two. The union of the
// keyframes' sections is a section, with a position for each vertex and keyframe; a frame is the sum of these positions
// with the weights of a Bernstein or uniform B-spline basis. It uses the builder of two-keyframe meshes, whose nodes
// have weights of their own: a node of the union that a section lacks has weight 0 there. For experiments, and as the
// reference of what the viewer shows by curves (client/mesh/terrain/curve_bend.h).
//
// Pure; any thread. O(n * vertices).
#pragma once

#include <functional>
#include <span>
#include <vector>

#include "client/mesh/patch/keyframe_mesh.h"
#include "proto/refine/metric/terrain_domain.h"
#include "proto/section/epoch_offsets.h"
#include "proto/section/node_tables.h"
#include "proto/section/section.h"

namespace foreland::oracle {

// How n + 1 keyframes are blended while u goes from 0 to 1.
//   Bernstein  the curve begins at the first keyframe and ends at the last: a mesh serves for n intervals
//   B-spline   the curve follows the keyframes and has n - 1 continuous derivatives: a mesh serves for one interval
// Of order 1 both are the linear blend.
enum class Basis : uint8_t { kBernstein, kBSpline };

// The n + 1 weights at u; not negative, of sum 1.
std::vector<double> basisWeights(Basis basis, int order, double u);
// Their derivatives by u.
std::vector<double> basisSlopes(Basis basis, int order, double u);

// A mesh with a position for each of several keyframes.
struct OrderMesh {
  std::vector<std::vector<glm::vec4>> positions;  // by keyframe, then by vertex, as BlendMesh::to_positions
  std::vector<glm::vec2> parameters;
  std::vector<uint32_t> indices;
  glm::dvec3 origin{0};

  glm::dvec4 at(size_t vertex, std::span<const double> weights) const;
};

// What a keyframe contributes.
struct BlendedKeyframe {
  proto::Section section;
  Time scene_time{};  // of the ground, in scenes with epochs
};

// The terrain of at least two keyframes. `records` gives the record of any node of a section; `offsets` is null if the
// ground does not move, else it knows the offsets of all nodes of the sections at their scene times.
OrderMesh blendSections(const proto::TerrainDomain& domain, proto::BaseHeights base,
                        const std::function<proto::NodeRecord(proto::Slot)>& records,
                        const proto::EpochOffsets* offsets, std::span<const BlendedKeyframe> keyframes,
                        const glm::dvec3& eye);

}  // namespace foreland::oracle
