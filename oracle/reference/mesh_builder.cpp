#include "oracle/reference/mesh_builder.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>

#include "client/mesh/patch/pack_normal.h"
#include "proto/section/epochs.h"

namespace foreland::oracle {

using client::bendOf;
using client::blendPosition;
using client::completeNormals;
using client::EndHeights;
using client::GroundPoint;
using client::groundPointAt;
using client::HeldNodes;
using client::KeyframeMesh;
using client::kInFrom;
using client::kInTo;
using client::kNoVertex;
using client::mixOf;
using client::Morph;
using client::packNormal;
using client::terrainFaceNormal;

MeshBuilder::MeshBuilder(const proto::TerrainDomain& domain, const HeldNodes& nodes, std::span<const Morph> morphs,
                         const EndHeights& heights, KeyframeMesh& mesh, uint32_t order)
    : domain_(domain),
      grid_(domain.grid),
      held_(nodes),
      nodes_(nodes, morphs),
      heights_(heights),
      face_normal_(terrainFaceNormal(domain)),
      mesh_(mesh),
      order_(order),
      limit_(static_cast<float>(grid_.shape().samples_x - 1), static_cast<float>(grid_.shape().samples_y - 1)) {}

void MeshBuilder::run() {
  addBaseVertices();
  for (uint32_t y = 0; y < grid_.shape().roots_y; ++y)
    for (uint32_t x = 0; x < grid_.shape().roots_x; ++x) visitRoot(x, y);
  finishNormals();
  writePositions();
}

// The corners of the root squares, then their centres; vertices of nodes follow.
void MeshBuilder::addBaseVertices() {
  const proto::GridShape& shape = grid_.shape();
  const uint32_t corners = (shape.roots_x + 1) * (shape.roots_y + 1), size = grid_.rootSize();
  const size_t count = corners + shape.roots_x * shape.roots_y + nodes_.size();
  vertices_.reserve(count);
  vertex_of_node_.assign(nodes_.size(), kNoVertex);
  mesh_.parameters.reserve(count);
  mesh_.indices.reserve(6 * count);
  const auto add = [&](uint32_t x, uint32_t y) {
    const LatticePoint at{static_cast<int32_t>(x), static_cast<int32_t>(y)};
    root_x_ = std::min(x >> shape.root_log2, shape.roots_x - 1);
    vertices_.push_back({.drawn = {{{truePosition(at, 0), true}, {truePosition(at, 1), true}}}});
    mesh_.parameters.emplace_back(static_cast<float>(x), static_cast<float>(y));
  };
  for (uint32_t y = 0; y <= shape.roots_y; ++y)
    for (uint32_t x = 0; x <= shape.roots_x; ++x) add(x * size, y * size);
  for (uint32_t y = 0; y < shape.roots_y; ++y)
    for (uint32_t x = 0; x < shape.roots_x; ++x) add(x * size + size / 2, y * size + size / 2);
}

void MeshBuilder::visitRoot(uint32_t root_x, uint32_t root_y) {
  root_x_ = root_x;
  const auto corner = [&](uint32_t east, uint32_t north) {
    const uint32_t size = grid_.rootSize();
    return proto::baseVertexNumber(
        grid_, grid_.nameIn(root_x, proto::NodeId::at((root_x + east) * size, (root_y + north) * size)));
  };
  const uint32_t sw = corner(0, 0), se = corner(1, 0), nw = corner(0, 1), ne = corner(1, 1);
  const proto::GridShape& shape = grid_.shape();
  const uint32_t centre = (shape.roots_x + 1) * (shape.roots_y + 1) + root_y * shape.roots_x + root_x;
  const int32_t half = static_cast<int32_t>(grid_.rootSize() / 2), levels = grid_.maxLevel();
  const int32_t x = static_cast<int32_t>(root_x) * 2 * half + half, y = static_cast<int32_t>(root_y) * 2 * half + half;
  const uint8_t both = kInFrom | kInTo;
  visit({{x, y - half}, {half, 0}, sw, se, centre, levels, both});
  visit({{x + half, y}, {0, half}, se, ne, centre, levels, both});
  visit({{x, y + half}, {-half, 0}, ne, nw, centre, levels, both});
  visit({{x - half, y}, {0, -half}, nw, sw, centre, levels, both});
}

void MeshBuilder::visit(const Triangle& t) {
  HeldNodes::Index::Found node;
  if (t.levels_below > 0) node = nodes_.find(grid_.slot(nameOf(t.m)));
  if (const uint8_t is_leaf_in = t.in & ~node.in; is_leaf_in != 0) addNormals(is_leaf_in, t);
  if (node.in == 0) return emit(t.a, t.b, t.apex);
  const uint32_t v = vertexOf(t, node);
  const uint8_t in = t.in & node.in;
  const LatticePoint rot{-t.d.y, t.d.x};
  const LatticePoint to_a{(rot.x - t.d.x) / 2, (rot.y - t.d.y) / 2}, to_b{(rot.x + t.d.x) / 2, (rot.y + t.d.y) / 2};
  visit({{t.m.x + to_a.x, t.m.y + to_a.y}, {-to_b.x, -to_b.y}, t.apex, t.a, v, t.levels_below - 1, in});
  visit({{t.m.x + to_b.x, t.m.y + to_b.y}, to_a, t.b, t.apex, v, t.levels_below - 1, in});
}

// The vertex of a node, made when the descent reaches the first of its triangles.
uint32_t MeshBuilder::vertexOf(const Triangle& t, const HeldNodes::Index::Found& node) {
  uint32_t& index = vertex_of_node_[node.position];
  if (index != kNoVertex) return index;
  index = static_cast<uint32_t>(vertices_.size());
  Vertex vertex{.drawn = {}, .endpoints = {t.a, t.b}, .in = node.in};
  const proto::NodeId name = nameOf(t.m);
  mesh_.parameters.emplace_back(static_cast<float>(name.x()), static_cast<float>(name.y()));
  const std::array<double, 2> weight = nodes_.weight(node);
  const auto position = [&](size_t s) { return positionAt(t.m, nodes_.height(node), s); };
  const auto displacement = [&](size_t s) {
    return position(s) -
           0.5 * (truePosition({t.m.x - t.d.x, t.m.y - t.d.y}, s) + truePosition({t.m.x + t.d.x, t.m.y + t.d.y}, s));
  };
  for (size_t s = 0; s < 2; ++s)
    vertex.drawn[s] = blendPosition(
        vertices_[t.a].drawn[s], vertices_[t.b].drawn[s], weight[s], [&] { return position(s); },
        [&] { return displacement(s); });
  if (const Morph* m = order_ > 1 ? nodes_.morph(node) : nullptr)
    vertex.bend = bendOf(vertices_[t.a].bend, vertices_[t.b].bend, *m, order_, displacement(0).position,
                         displacement(1).position);
  vertices_.push_back(vertex);
  return index;
}

GroundPoint MeshBuilder::positionAt(LatticePoint at, int32_t height, size_t end) const {
  return groundPointAt(domain_, heights_, nameOf(at), height, end);
}

GroundPoint MeshBuilder::truePosition(LatticePoint at, size_t end) const {
  return positionAt(at, held_.records().height(nameOf(at)), end);
}

void MeshBuilder::addNormals(uint8_t sections, const Triangle& t) {
  Vertex &a = vertices_[t.a], &b = vertices_[t.b], &apex = vertices_[t.apex];
  for (size_t s = 0; s < 2; ++s) {
    if (!(sections >> s & 1)) continue;
    const glm::dvec3 n =
        face_normal_(a.drawn[s].position.position, b.drawn[s].position.position, apex.drawn[s].position.position);
    for (Vertex* v : {&a, &b, &apex}) v->normal[s] += n;
  }
}

void MeshBuilder::emit(uint32_t a, uint32_t b, uint32_t c) {
  if (isBeyond(a, 0) || isBeyond(b, 0) || isBeyond(c, 0) || isBeyond(a, 1) || isBeyond(b, 1) || isBeyond(c, 1))
    return clip({a, b, c});
  mesh_.indices.insert(mesh_.indices.end(), {a, b, c});
}

// Sutherland and Hodgman's clipping against the two far borders of the data. Each edge gets its vertex on a border
// once, so neighbouring triangles still share it.
void MeshBuilder::clip(std::array<uint32_t, 3> corners) {
  std::vector<uint32_t> polygon(corners.begin(), corners.end()), next;
  for (int axis = 0; axis < 2; ++axis) {
    next.clear();
    for (size_t i = 0; i < polygon.size(); ++i) {
      const uint32_t p = polygon[i], q = polygon[(i + 1) % polygon.size()];
      const bool p_out = isBeyond(p, axis), q_out = isBeyond(q, axis);
      if (!p_out) next.push_back(p);
      if (p_out != q_out) {
        const uint32_t inside = p_out ? q : p;
        if (mesh_.parameters[inside][axis] == limit_[axis]) continue;  // it lies on the border itself
        next.push_back(cutEdge(inside, p_out ? p : q, axis));
      }
    }
    polygon.swap(next);
  }
  // A triangle that touches the border from outside leaves a point or an edge, which has no area and is not drawn.
  for (size_t i = 2; i < polygon.size(); ++i) {
    const glm::vec2 a = mesh_.parameters[polygon[0]], b = mesh_.parameters[polygon[i - 1]],
                    c = mesh_.parameters[polygon[i]];
    const float area = (b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x);
    if (area > 0) mesh_.indices.insert(mesh_.indices.end(), {polygon[0], polygon[i - 1], polygon[i]});
  }
}

uint32_t MeshBuilder::cutEdge(uint32_t inside, uint32_t outside, int axis) {
  const auto [it, is_new] = cuts_.try_emplace({inside, outside, static_cast<uint32_t>(axis)}, mesh_.parameters.size());
  if (!is_new) return it->second;
  const glm::vec2 p = mesh_.parameters[inside], q = mesh_.parameters[outside];
  const double u = (static_cast<double>(limit_[axis]) - p[axis]) / (static_cast<double>(q[axis]) - p[axis]);
  glm::vec2 on_border = p + static_cast<float>(u) * (q - p);
  on_border[axis] = limit_[axis];
  mesh_.parameters.push_back(on_border);
  Vertex vertex{.drawn = {}, .endpoints = {inside, outside}, .in = 0};
  for (size_t s = 0; s < 2; ++s) {
    const GroundPoint from = vertices_[inside].drawn[s].position, to = vertices_[outside].drawn[s].position;
    vertex.drawn[s] = {from + u * (to - from), false};
  }
  vertex.bend = mixOf(vertices_[inside].bend, vertices_[outside].bend, u);
  vertices_.push_back(vertex);
  return it->second;
}

void MeshBuilder::finishNormals() {
  for (size_t s = 0; s < 2; ++s) {
    completeNormals(
        vertices_.size(), [this, s](size_t v) { return (vertices_[v].in >> s & 1) != 0; },
        [this](size_t v) { return vertices_[v].endpoints; },
        [this, s](size_t v) -> glm::dvec3& { return vertices_[v].normal[s]; });
    auto& packed = s == 0 ? mesh_.from_normals : mesh_.to_normals;
    packed.reserve(vertices_.size());
    for (const Vertex& v : vertices_) packed.push_back(packNormal(v.normal[s]));
  }
}

void MeshBuilder::writePositions() {
  for (size_t s = 0; s < 2; ++s) {
    auto& out = s == 0 ? mesh_.from_positions : mesh_.to_positions;
    auto& moved = s == 0 ? mesh_.from_moved : mesh_.to_moved;
    out.reserve(vertices_.size());
    for (const Vertex& v : vertices_) {
      const GroundPoint& p = v.drawn[s].position;
      out.emplace_back(glm::vec3(p.position - mesh_.origin), static_cast<float>(p.height_m));
      if (heights_.isMoving()) moved.push_back(static_cast<float>(p.moved_m));
    }
  }
  if (order_ > 1)
    for (const Vertex& v : vertices_)
      mesh_.from_bends.emplace_back(v.bend.from), mesh_.to_bends.emplace_back(v.bend.to);
  mesh_.from_nodes = nodes_.fromCount();
  mesh_.to_nodes = nodes_.toCount();
}

}  // namespace foreland::oracle
