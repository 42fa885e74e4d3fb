#include "client/mesh_builder.h"

#include <cmath>
#include <glm/geometric.hpp>

#include "client/pack_normal.h"

namespace foreland::client {

MeshBuilder::MeshBuilder(const Replica& replica, KeyframeMesh& mesh)
    : replica_(replica),
      grid_(replica.grid()),
      nodes_(replica.nodes(), replica.morphs().all()),
      mesh_(mesh),
      limit_(static_cast<float>(grid_.shape().samples_x - 1), static_cast<float>(grid_.shape().samples_y - 1)) {}

void MeshBuilder::run() {
  placeBase();
  for (uint32_t y = 0; y < grid_.shape().roots_y; ++y)
    for (uint32_t x = 0; x < grid_.shape().roots_x; ++x) visitRoot(x, y);
  finishNormals();
  writePositions();
}

// Vertices: corners, centres, then the nodes.
void MeshBuilder::placeBase() {
  const proto::GridShape& shape = grid_.shape();
  const uint32_t corners = (shape.roots_x + 1) * (shape.roots_y + 1), size = grid_.rootSize();
  const size_t count = corners + shape.roots_x * shape.roots_y + nodes_.size();
  vertices_.reserve(count);
  numbers_.assign(nodes_.size(), kNoEnd);
  mesh_.places.reserve(count);
  mesh_.indices.reserve(6 * count);
  const auto place = [&](uint32_t x, uint32_t y) {
    const glm::dvec4 own = knownPlace({static_cast<int32_t>(x), static_cast<int32_t>(y)});
    vertices_.push_back({.drawn = {{{own, true}, {own, true}}}});
    mesh_.places.emplace_back(static_cast<float>(x), static_cast<float>(y));
  };
  for (uint32_t y = 0; y <= shape.roots_y; ++y)
    for (uint32_t x = 0; x <= shape.roots_x; ++x) place(x * size, y * size);
  for (uint32_t y = 0; y < shape.roots_y; ++y)
    for (uint32_t x = 0; x < shape.roots_x; ++x) place(x * size + size / 2, y * size + size / 2);
}

void MeshBuilder::visitRoot(uint32_t root_x, uint32_t root_y) {
  const proto::GridShape& shape = grid_.shape();
  const uint32_t row = shape.roots_x + 1, sw = root_y * row + root_x, se = sw + 1, nw = sw + row, ne = nw + 1;
  const uint32_t centre = row * (shape.roots_y + 1) + root_y * shape.roots_x + root_x;
  const int32_t half = static_cast<int32_t>(grid_.rootSize() / 2), levels = grid_.maxLevel();
  const int32_t x = static_cast<int32_t>(root_x) * 2 * half + half, y = static_cast<int32_t>(root_y) * 2 * half + half;
  const uint8_t both = kInFrom | kInTo;
  visit({{x, y - half}, {half, 0}, sw, se, centre, levels, both});
  visit({{x + half, y}, {0, half}, se, ne, centre, levels, both});
  visit({{x, y + half}, {-half, 0}, ne, nw, centre, levels, both});
  visit({{x - half, y}, {0, -half}, nw, sw, centre, levels, both});
}

void MeshBuilder::visit(const Triangle& t) {
  HeldNodes::Row::Found node;
  if (t.levels > 0)
    node = nodes_.find(grid_.slot(proto::NodeId::at(static_cast<uint32_t>(t.m.x), static_cast<uint32_t>(t.m.y))));
  if (const uint8_t ends_here = t.live & ~node.in; ends_here != 0) addNormals(ends_here, t);
  if (node.in == 0) return emit(t.a, t.b, t.apex);
  const uint32_t v = splitVertex(t, node);
  const uint8_t live = t.live & node.in;
  const Lattice rot{-t.d.y, t.d.x};
  const Lattice in{(rot.x - t.d.x) / 2, (rot.y - t.d.y) / 2}, on{(rot.x + t.d.x) / 2, (rot.y + t.d.y) / 2};
  visit({{t.m.x + in.x, t.m.y + in.y}, {-on.x, -on.y}, t.apex, t.a, v, t.levels - 1, live});
  visit({{t.m.x + on.x, t.m.y + on.y}, in, t.b, t.apex, v, t.levels - 1, live});
}

// The vertex of a node, placed when the first of its triangles gets there.
uint32_t MeshBuilder::splitVertex(const Triangle& t, const HeldNodes::Row::Found& node) {
  uint32_t& number = numbers_[node.position];
  if (number != kNoEnd) return number;
  number = static_cast<uint32_t>(vertices_.size());
  Vertex vertex{.drawn = {}, .ends = {t.a, t.b}};
  mesh_.places.emplace_back(static_cast<float>(t.m.x), static_cast<float>(t.m.y));
  const glm::dvec4 own = placeOf(t.m, nodes_.height(node));
  const std::array<double, 2> weight = nodes_.weight(node);
  const auto displacement = [&] {
    return own - 0.5 * (knownPlace({t.m.x - t.d.x, t.m.y - t.d.y}) + knownPlace({t.m.x + t.d.x, t.m.y + t.d.y}));
  };
  for (size_t s = 0; s < 2; ++s)
    vertex.drawn[s] = blendPosition(
        vertices_[t.a].drawn[s], vertices_[t.b].drawn[s], weight[s], [&] { return own; }, displacement);
  vertices_.push_back(vertex);
  return number;
}

glm::dvec4 MeshBuilder::placeOf(Lattice at, int32_t height) const {
  const proto::NodeId v = proto::NodeId::at(static_cast<uint32_t>(at.x), static_cast<uint32_t>(at.y));
  const double height_m = height * replica_.frameGrid().transform().frame().height_quantum_m;
  return {replica_.frameGrid().position(v, height), height_m};
}

glm::dvec4 MeshBuilder::knownPlace(Lattice at) const {
  const proto::NodeId v = proto::NodeId::at(static_cast<uint32_t>(at.x), static_cast<uint32_t>(at.y));
  return placeOf(at, *replica_.knownHeight(v));
}

void MeshBuilder::addNormals(uint8_t sections, const Triangle& t) {
  Vertex &a = vertices_[t.a], &b = vertices_[t.b], &apex = vertices_[t.apex];
  for (size_t s = 0; s < 2; ++s) {
    if (!(sections >> s & 1)) continue;
    const glm::dvec3 from(a.drawn[s].at);
    const glm::dvec3 n = glm::cross(glm::dvec3(b.drawn[s].at) - from, glm::dvec3(apex.drawn[s].at) - from);
    for (Vertex* v : {&a, &b, &apex}) v->normal[s] += n;
  }
}

void MeshBuilder::emit(uint32_t a, uint32_t b, uint32_t c) {
  if (beyond(a, 0) || beyond(b, 0) || beyond(c, 0) || beyond(a, 1) || beyond(b, 1) || beyond(c, 1))
    return clip({a, b, c});
  mesh_.indices.insert(mesh_.indices.end(), {a, b, c});
}

// Sutherland and Hodgman against the two far borders of the data. Vertices on a border are made once per edge, so
// neighbours still share them.
void MeshBuilder::clip(std::array<uint32_t, 3> corners) {
  std::vector<uint32_t> polygon(corners.begin(), corners.end()), next;
  for (int axis = 0; axis < 2; ++axis) {
    next.clear();
    for (size_t i = 0; i < polygon.size(); ++i) {
      const uint32_t p = polygon[i], q = polygon[(i + 1) % polygon.size()];
      const bool p_out = beyond(p, axis), q_out = beyond(q, axis);
      if (!p_out) next.push_back(p);
      if (p_out != q_out) {
        const uint32_t inside = p_out ? q : p;
        if (mesh_.places[inside][axis] == limit_[axis]) continue;  // the edge leaves the data at its own end
        next.push_back(cut(inside, p_out ? p : q, axis));
      }
    }
    polygon.swap(next);
  }
  // Only what has an area: a triangle that touches the border from outside leaves a point or an edge.
  for (size_t i = 2; i < polygon.size(); ++i) {
    const glm::vec2 a = mesh_.places[polygon[0]], b = mesh_.places[polygon[i - 1]], c = mesh_.places[polygon[i]];
    const float area = (b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x);
    if (area > 0) mesh_.indices.insert(mesh_.indices.end(), {polygon[0], polygon[i - 1], polygon[i]});
  }
}

uint32_t MeshBuilder::cut(uint32_t inside, uint32_t outside, int axis) {
  const auto [it, is_new] = cuts_.try_emplace({inside, outside, static_cast<uint32_t>(axis)}, mesh_.places.size());
  if (!is_new) return it->second;
  const glm::vec2 p = mesh_.places[inside], q = mesh_.places[outside];
  const double u = (static_cast<double>(limit_[axis]) - p[axis]) / (static_cast<double>(q[axis]) - p[axis]);
  glm::vec2 place = p + static_cast<float>(u) * (q - p);
  place[axis] = limit_[axis];
  mesh_.places.push_back(place);
  Vertex vertex{.drawn = {}, .ends = {inside, outside}};
  for (size_t s = 0; s < 2; ++s) {
    const glm::dvec4 from = vertices_[inside].drawn[s].at, to = vertices_[outside].drawn[s].at;
    vertex.drawn[s] = {from + u * (to - from), false};
  }
  vertices_.push_back(vertex);
  return it->second;
}

void MeshBuilder::finishNormals() {
  for (size_t s = 0; s < 2; ++s) {
    settleNormals(
        vertices_.size(), [this](size_t v) { return vertices_[v].ends; },
        [this, s](size_t v) -> glm::dvec3& { return vertices_[v].normal[s]; });
    auto& packed = s == 0 ? mesh_.from_normals : mesh_.to_normals;
    packed.reserve(vertices_.size());
    for (const Vertex& v : vertices_) packed.push_back(packNormal(v.normal[s]));
  }
}

void MeshBuilder::writePositions() {
  mesh_.origin = glm::round(mesh_.to.pose.eye);
  for (size_t s = 0; s < 2; ++s) {
    auto& out = s == 0 ? mesh_.from_positions : mesh_.to_positions;
    out.reserve(vertices_.size());
    for (const Vertex& v : vertices_) {
      const glm::dvec4& p = v.drawn[s].at;
      out.emplace_back(glm::vec3(glm::dvec3(p) - mesh_.origin), static_cast<float>(p.w));
    }
  }
  mesh_.from_nodes = nodes_.fromCount();
  mesh_.to_nodes = nodes_.toCount();
}

}  // namespace foreland::client
