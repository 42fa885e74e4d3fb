#include "oracle/reference/order_blend.h"

#include <algorithm>

#include "base/check.h"
#include "base/sort.h"
#include "oracle/reference/mesh_builder.h"

namespace foreland::oracle {

using client::EndHeights;
using client::HeldNodes;
using client::KeyframeMesh;
using client::kInFrom;
using client::kInTo;
using client::Morph;

namespace {

// de Casteljau's and de Boor's recursions, on weights instead of points.
std::vector<double> raised(Basis basis, const std::vector<double>& lower, double u) {
  const auto order = static_cast<double>(lower.size());
  std::vector<double> weights(lower.size() + 1, 0);
  for (size_t i = 0; i < lower.size(); ++i) {
    const double share = basis == Basis::kBernstein ? u : (u + order - 1 - static_cast<double>(i)) / order;
    weights[i] += (1 - share) * lower[i];
    weights[i + 1] += share * lower[i];
  }
  return weights;
}

proto::Section unionOf(std::span<const BlendedKeyframe> keyframes) {
  proto::Section all;
  for (const BlendedKeyframe& keyframe : keyframes)
    all.slots.insert(all.slots.end(), keyframe.section.slots.begin(), keyframe.section.slots.end());
  foreland::sort(all.slots.begin(), all.slots.end());
  all.slots.erase(std::unique(all.slots.begin(), all.slots.end()), all.slots.end());
  return all;
}

// The weights of the union's nodes where keyframe `from` is shown alone, and where `to` is.
std::vector<Morph> morphsBetween(const proto::Section& all, const proto::Section& from, const proto::Section& to) {
  std::vector<Morph> morphs;
  for (proto::Slot slot : all.slots) {
    const double a = proto::contains(from, slot) ? 1 : 0, b = proto::contains(to, slot) ? 1 : 0;
    if (a == 1 && b == 1) continue;
    morphs.push_back({.slot = slot, .is_added = b == 1, .in = kInFrom | kInTo, .from = a, .to = b});
  }
  return morphs;
}

}  // namespace

std::vector<double> basisWeights(Basis basis, int order, double u) {
  CHECK_GE(order, 1);
  std::vector<double> weights{1};
  for (int n = 1; n <= order; ++n) weights = raised(basis, weights, u);
  return weights;
}

std::vector<double> basisSlopes(Basis basis, int order, double u) {
  CHECK_GE(order, 1);
  std::vector<double> lower{1};
  for (int n = 1; n < order; ++n) lower = raised(basis, lower, u);
  const double scale = basis == Basis::kBernstein ? order : 1;
  std::vector<double> slopes(lower.size() + 1, 0);
  for (size_t i = 0; i < lower.size(); ++i) {
    slopes[i] -= scale * lower[i];
    slopes[i + 1] += scale * lower[i];
  }
  return slopes;
}

glm::dvec4 OrderMesh::at(size_t vertex, std::span<const double> weights) const {
  glm::dvec4 sum(0);
  for (size_t i = 0; i < weights.size(); ++i) sum += weights[i] * glm::dvec4(positions[i][vertex]);
  return sum;
}

OrderMesh blendSections(const proto::TerrainDomain& domain, proto::BaseHeights base,
                        const std::function<proto::NodeRecord(proto::Slot)>& records,
                        const proto::EpochOffsets* offsets, std::span<const BlendedKeyframe> keyframes,
                        const glm::dvec3& eye) {
  CHECK_GE(keyframes.size(), 2u);
  const proto::Section all = unionOf(keyframes);
  HeldNodes nodes(domain.grid, base);
  for (proto::Slot slot : all.slots) nodes.records().make(slot) = records(slot);
  nodes.step({all.slots, {}});
  nodes.step({});
  OrderMesh mesh;
  for (size_t first = 0; first < keyframes.size(); first += 2) {
    const size_t from = std::min(first, keyframes.size() - 2), to = from + 1;
    KeyframeMesh pair;
    pair.to.pose.eye = eye;
    const EndHeights heights =
        offsets ? EndHeights(*offsets, keyframes[from].scene_time, keyframes[to].scene_time) : EndHeights();
    const std::vector<Morph> morphs = morphsBetween(all, keyframes[from].section, keyframes[to].section);
    MeshBuilder(domain, nodes, morphs, heights, pair).run();
    mesh.positions.resize(to + 1);
    mesh.positions[from] = std::move(pair.from_positions);
    mesh.positions[to] = std::move(pair.to_positions);
    mesh.parameters = std::move(pair.parameters);
    mesh.indices = std::move(pair.indices);
    mesh.origin = pair.origin;
  }
  return mesh;
}

}  // namespace foreland::oracle
