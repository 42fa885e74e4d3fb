#include "client/mesh/terrain/border_cuts.h"

namespace foreland::client {

glm::vec2 BorderCuts::parameterOf(uint32_t v, const TerrainVertices& vertices) const {
  if (const auto it = parameters_.find(v); it != parameters_.end()) return it->second;
  const proto::NodeId id = vertices[v].id;
  return {static_cast<float>(id.x()), static_cast<float>(id.y())};
}

// Sutherland and Hodgman's clipping against the two far borders, as oracle::MeshBuilder::clip.
uint32_t BorderCuts::add(const TrianglePlaces::Corners& corners, const Mesh& mesh) {
  const uint32_t leaf = takePlace(leaves_, free_leaves_);
  leaves_[leaf] = {};
  polygon_.assign(corners.begin(), corners.end());
  for (int axis = 0; axis < 2; ++axis) {
    const auto at = [&](uint32_t v) { return parameterOf(v, mesh.vertices)[axis]; };
    next_.clear();
    for (size_t i = 0; i < polygon_.size(); ++i) {
      const uint32_t p = polygon_[i], q = polygon_[(i + 1) % polygon_.size()];
      const bool p_out = at(p) > limit_[axis], q_out = at(q) > limit_[axis];
      if (!p_out) next_.push_back(p);
      if (p_out == q_out) continue;
      const Step step{axis, p_out ? Key{q, p} : Key{p, q}};
      if (at(step.key[0]) == limit_[axis]) continue;  // it lies on the border itself
      leaves_[leaf].cuts[leaves_[leaf].cut_count++] = step;
      next_.push_back(cutEdge(step, mesh));
    }
    polygon_.swap(next_);
  }
  drawFan(leaf, polygon_, mesh);
  return leaf;
}

// A triangle that touches the border from outside leaves a point or an edge, which has no area and is not drawn.
void BorderCuts::drawFan(uint32_t number, const std::vector<uint32_t>& polygon, const Mesh& mesh) {
  Leaf& leaf = leaves_[number];
  for (size_t i = 2; i < polygon.size(); ++i) {
    const glm::vec2 a = parameterOf(polygon[0], mesh.vertices), b = parameterOf(polygon[i - 1], mesh.vertices),
                    c = parameterOf(polygon[i], mesh.vertices);
    const float area = (b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x);
    if (!(area > 0)) continue;
    leaf.triangles[leaf.triangle_count] =
        mesh.triangles.add({polygon[0], polygon[i - 1], polygon[i]}, kOwner | (number * 4 + leaf.triangle_count));
    ++leaf.triangle_count;
  }
}

uint32_t BorderCuts::cutEdge(const Step& step, const Mesh& mesh) {
  const int axis = step.axis;
  const auto [it, is_new] = cuts_[static_cast<size_t>(axis)].try_emplace(step.key, Cut{});
  Cut& cut = it->second;
  ++cut.leaves;
  if (!is_new) return cut.vertex;
  const glm::vec2 p = parameterOf(step.key[0], mesh.vertices), q = parameterOf(step.key[1], mesh.vertices);
  cut.at = (static_cast<double>(limit_[axis]) - p[axis]) / (static_cast<double>(q[axis]) - p[axis]);
  cut.parameter = p + static_cast<float>(cut.at) * (q - p);
  cut.parameter[axis] = limit_[axis];
  cut.is_new = true;
  cut.vertex = mesh.vertices.add();
  parameters_[cut.vertex] = cut.parameter;
  mesh.writer.addVertex(cut.vertex, cut.parameter);
  return cut.vertex;
}

void BorderCuts::remove(uint32_t number, const Mesh& mesh) {
  const Leaf& leaf = leaves_[number];
  for (uint32_t i = 0; i < leaf.triangle_count; ++i) mesh.triangles.remove(leaf.triangles[i]);
  for (uint32_t i = 0; i < leaf.cut_count; ++i) {
    auto& cuts = cuts_[static_cast<size_t>(leaf.cuts[i].axis)];
    const auto it = cuts.find(leaf.cuts[i].key);
    if (--it->second.leaves > 0) continue;
    mesh.vertices.remove(it->second.vertex);
    parameters_.erase(it->second.vertex);
    cuts.erase(it);
  }
  free_leaves_.push_back(number);
}

void BorderCuts::refresh(const Mesh& mesh) {
  const auto isTouched = [&](uint32_t v) {
    return mesh.vertices[v].position_entry != kNoVertex || mesh.vertices[v].normal_entry != kNoVertex;
  };
  for (auto& cuts : cuts_)
    for (auto& [key, cut] : cuts) {
      if (!cut.is_new && !isTouched(key[0]) && !isTouched(key[1])) continue;
      cut.is_new = false;
      mesh.writer.touchPosition(cut.vertex);
      mesh.writer.touchNormal(cut.vertex);
      const TerrainVertex &inside = mesh.vertices[key[0]], &outside = mesh.vertices[key[1]];
      TerrainVertex& vertex = mesh.vertices[cut.vertex];
      vertex.moveTo(inside.point() + cut.at * (outside.point() - inside.point()));
      vertex.normal = unitNormal(inside.unitNormal() + outside.unitNormal());
    }
}

}  // namespace foreland::client
