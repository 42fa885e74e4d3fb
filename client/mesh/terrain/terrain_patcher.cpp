#include "client/mesh/terrain/terrain_patcher.h"

#include <algorithm>
#include <iterator>
#include <utility>

#include "base/check.h"
#include "proto/section/epochs.h"

namespace foreland::client {

using proto::NodeId;
using proto::Slot;

namespace {

// How the diamond's corners are numbered around a node (terrain_vertices.h).
bool isOnSide(NodeId n, uint32_t scale_log2) { return ((n.x() >> scale_log2) & (n.y() >> scale_log2) & 1) == 0; }

// Corners 1 and 3 are apexes if the endpoints are west and east, or south-west and north-east.
uint8_t firstApexOf(NodeId n, uint32_t scale_log2) {
  const uint32_t x = n.x() >> scale_log2, y = n.y() >> scale_log2;
  return static_cast<uint8_t>((y & 1) == 0 || ((x & 1) != 0 && ((x ^ y) & 2) == 0) ? 1 : 0);
}

// The number of the corner at `corner` in the diamond around n.
uint32_t cornerAt(NodeId n, NodeId corner, bool is_on_side) {
  const bool east = corner.x() > n.x(), north = corner.y() > n.y();
  if (!is_on_side) return north ? (east ? 0 : 1) : (east ? 3 : 2);
  if (corner.y() == n.y()) return east ? 0 : 2;
  return north ? 1 : 3;
}

std::vector<Slot> unionOf(std::span<const Slot> a, std::span<const Slot> b) {
  std::vector<Slot> out;
  out.reserve(a.size() + b.size());
  std::set_union(a.begin(), a.end(), b.begin(), b.end(), std::back_inserter(out));
  return out;
}

// The number of the corner where apexes() has its first or second apex, if it has two.
uint32_t cornerOfApex(int i, uint8_t first_apex, bool is_on_side) {
  const bool is_falling_back = (i == 0) == (is_on_side || first_apex == 0);
  return first_apex + (is_falling_back ? 2u : 0u);
}

// The number of the triangle of an apex that a child halves which has the apex as its corner `corner`.
uint32_t triangleOf(uint32_t corner, bool child_is_on_side) { return (corner + (child_is_on_side ? 1 : 2)) % 4; }

}  // namespace

TerrainPatcher::TerrainPatcher(const proto::TerrainDomain& domain)
    : domain_(domain),
      grid_(domain.grid),
      face_normal_(terrainFaceNormal(domain)),
      limit_(static_cast<float>(grid_.shape().samples_x - 1), static_cast<float>(grid_.shape().samples_y - 1)),
      cuts_(limit_) {}

void TerrainPatcher::rebuild(const TerrainStep& step, BlendPatch& out) {
  vertices_ = {};
  triangles_ = {};
  cuts_ = BorderCuts(limit_);
  leaving_.clear();
  moving_in_section_ = section_nodes_ = 0;
  origin_ = step.origin;
  scene_time_ = step.scene_from;
  out.is_whole = true;
  PatchWriter writer(vertices_, origin_, step.heights.isMoving(), out);
  step_ = &step, writer_ = &writer;
  addBaseVertices();
  const Slots& removed = step.morphs.drawn().removed;
  Slots from, both;
  const Slots to = step.nodes.newest().slots;
  const Slots& added = step.morphs.drawn().added;
  std::set_union(to.begin(), to.end(), removed.begin(), removed.end(), std::back_inserter(both));
  std::set_difference(both.begin(), both.end(), added.begin(), added.end(), std::back_inserter(from));
  splitUnion(both);
  enterSection(from, placesOf(from), End::kFrom);
  advance(step, out);
}

void TerrainPatcher::step(const TerrainStep& step, BlendPatch& out) {
  const proto::CutDelta &jumped = step.morphs.jumped(), &drawn = step.morphs.drawn();
  const Slots leaving = unionOf(leaving_, jumped.removed), entering = unionOf(jumped.added, drawn.added);
  if (willBeSparse(step.nodes, leaving, entering)) return rebuild(step, out);
  const bool has_new_origin = std::exchange(origin_, step.origin) != step.origin;
  PatchWriter writer(vertices_, origin_, step.heights.isMoving(), out);
  step_ = &step, writer_ = &writer;
  if (has_new_origin)
    for (uint32_t v = 0; v < vertices_.count(); ++v)
      if (vertices_[v].is_used) writer.touchPosition(v);

  leaveSection(placesOf(jumped.removed));
  mergeUnion(leaving);
  splitUnion(entering);
  if (isSparse(vertices_.used())) {  // since cuts have gone, too
    out.clear();
    return rebuild(step, out);
  }
  moveWithin(End::kFrom);
  enterSection(jumped.added, placesOf(jumped.added), End::kFrom);
  advance(step, out);
}

// Whether too few places will be in use for the mesh to be brought to the next one, as far as nodes count. Look-ups
// only if it may be so.
bool TerrainPatcher::willBeSparse(const HeldNodes& nodes, const Slots& leaving, const Slots& entering) const {
  if (!isSparse(vertices_.used() - leaving.size())) return false;
  const auto gone = std::count_if(leaving.begin(), leaving.end(), [&](Slot slot) { return nodes.in(slot) == 0; });
  const auto come =
      std::count_if(entering.begin(), entering.end(), [&](Slot slot) { return vertices_.find(slot) == kNoVertex; });
  return isSparse(vertices_.used() - static_cast<size_t>(gone) + static_cast<size_t>(come));
}

// From the mesh's beginning, which the section already has, to its end.
void TerrainPatcher::advance(const TerrainStep& step, BlendPatch& out) {
  const proto::CutDelta& drawn = step.morphs.drawn();
  const Places added = placesOf(drawn.added), removed = placesOf(drawn.removed);
  if (step.order > 1) touchCurved();
  lieOnEdges(added);
  cuts_.refresh(mesh());
  writer_->beginDone();
  from_nodes_ = section_nodes_;

  leaveSection(removed);
  moveWithin(End::kTo);
  scene_time_ = step.scene_to;
  enterSection(drawn.added, added, End::kTo);
  lieOnEdges(removed);
  cuts_.refresh(mesh());
  out.tells_bends = step.order > 1;
  if (step.order > 1) writeBends(out);
  writer_->endDone();

  leaving_ = drawn.removed;
  const auto moved = [this](uint32_t owner, uint32_t, uint32_t place) {
    if ((owner & BorderCuts::kOwner) != 0) return cuts_.move(owner, place);
    vertices_[owner / 4].links[owner % 4] = Link::of(Link::Kind::kTriangle, place);
  };
  triangles_.finish(moved, out);
  step_ = nullptr, writer_ = nullptr;
}

void TerrainPatcher::addBaseVertex(uint32_t x, uint32_t y) {
  const uint32_t v = vertices_.add();
  TerrainVertex& vertex = vertices_[v];
  vertex.id = NodeId::at(x, y);
  vertex.moveTo(truePosition(vertex.id, now().nodes.records().height(vertex.id), End::kFrom));
  vertex.is_in_section = vertex.is_true = true;
  const glm::vec2 parameter(static_cast<float>(x), static_cast<float>(y));
  vertex.is_beyond = parameter.x > limit_.x || parameter.y > limit_.y;
  writer_->addVertex(v, parameter);
}

// The corners of the root squares, then their centres, whose triangles are the roots of the hierarchy.
void TerrainPatcher::addBaseVertices() {
  const proto::GridShape& shape = grid_.shape();
  const uint32_t size = grid_.rootSize();
  for (uint32_t y = 0; y <= shape.roots_y; ++y)
    for (uint32_t x = 0; x <= shape.roots_x; ++x) addBaseVertex(x * size, y * size);
  for (uint32_t y = 0; y < shape.roots_y; ++y)
    for (uint32_t x = 0; x < shape.roots_x; ++x) addBaseVertex(x * size + size / 2, y * size + size / 2);
  for (uint32_t y = 0; y < shape.roots_y; ++y)
    for (uint32_t x = 0; x < shape.roots_x; ++x) addRootTriangles(x, y);
}

// Of a node or a root's centre.
uint32_t TerrainPatcher::placeOf(NodeId v) const {
  const proto::GridShape& shape = grid_.shape();
  if (!grid_.isBase(v)) return vertices_.find(grid_.slot(v));
  return cornerCount() + (v.y() >> shape.root_log2) * shape.roots_x + (v.x() >> shape.root_log2);
}

// On a cube, where either lies on an edge, so that the one's square may be turned against the other's: the number of
// the apex's triangle that a child halves.
uint32_t TerrainPatcher::triangleAcross(NodeId apex, NodeId child) const {
  const int level = grid_.level(apex);
  const proto::NodeList<4> children = grid_.children(apex, level);
  static constexpr uint8_t kOfCentre[] = {1, 3, 2, 0}, kOfSide[] = {2, 3, 1, 0};  // in the order of children()
  const auto i = std::find(children.begin(), children.end(), child) - children.begin();
  return level % 2 == 0 ? kOfCentre[i] : kOfSide[i];
}

void TerrainPatcher::addRootTriangles(uint32_t root_x, uint32_t root_y) {
  const uint32_t size = grid_.rootSize(), x = root_x * size, y = root_y * size;
  const auto corner = [&](uint32_t east, uint32_t north) {
    return proto::baseVertexNumber(grid_, grid_.nameIn(root_x, NodeId::at(x + east, y + north)));
  };
  const uint32_t centre = placeOf(NodeId::at(x + size / 2, y + size / 2));
  vertices_[centre].ring = {corner(size, size), corner(0, size), corner(0, 0), corner(size, 0)};
  for (uint32_t q = 0; q < 4; ++q) {
    setLeaf(centre, q);
    addNormal(vertices_[centre].ring[q], vertices_[centre].ring[(q + 1) % 4], centre, 1);
  }
}

GroundPoint TerrainPatcher::truePosition(NodeId v, int32_t height, End end) const {
  return groundPointAt(domain_, now().heights, v, height, end == End::kFrom ? 0 : 1);
}

void TerrainPatcher::setLeaf(uint32_t apex, uint32_t q) {
  TerrainVertex& vertex = vertices_[apex];
  const TrianglePlaces::Corners corners{vertex.ring[q], vertex.ring[(q + 1) % 4], apex};
  if (vertex.is_beyond || vertices_[corners[0]].is_beyond || vertices_[corners[1]].is_beyond) {
    const uint32_t leaf = cuts_.add(corners, mesh());  // which may move the vertices
    vertices_[apex].links[q] = Link::of(Link::Kind::kCut, leaf);
  } else {
    vertex.links[q] = Link::of(Link::Kind::kTriangle, triangles_.add(corners, 4 * apex + q));
  }
}

void TerrainPatcher::dropLeaf(uint32_t apex, uint32_t q) {
  const Link link = vertices_[apex].links[q];
  if (link.kind() == Link::Kind::kTriangle) triangles_.remove(link.index());
  if (link.kind() == Link::Kind::kCut) cuts_.remove(link.index(), mesh());
  vertices_[apex].links[q] = {};
}

// What a node's work will read is fetched some nodes ahead of it: the mesh is larger than the caches, and what changes
// lies all over it.
void TerrainPatcher::fetchAround(uint32_t v) const {
  for (uint32_t corner : vertices_[v].ring)
    if (corner != kNoVertex) vertices_.fetchState(corner);
}

TerrainPatcher::Places TerrainPatcher::placesOf(std::span<const Slot> slots) const {
  Places places;
  places.reserve(slots.size());
  for (Slot slot : slots) {
    places.push_back(vertices_.find(slot));
    if (places.back() != kNoVertex) vertices_.fetch(places.back());
  }
  return places;
}

// Makes the vertices of those that have none. Halves the triangles beside their edges there.
void TerrainPatcher::splitUnion(const Slots& slots) {
  entering_.clear();
  for (Slot slot : slots) {
    if (vertices_.find(slot) != kNoVertex) continue;
    entering_.push_back({slot, grid_.node(slot), {kNoVertex, kNoVertex}});
    Entering& e = entering_.back();
    const proto::NodeList<2> apexes = grid_.apexes(e.id);
    for (int i = 0; i < apexes.count; ++i) {
      e.apexes[static_cast<size_t>(i)] = placeOf(apexes.ids[i]);
      if (e.apexes[static_cast<size_t>(i)] != kNoVertex) vertices_.fetch(e.apexes[static_cast<size_t>(i)]);
    }
  }
  for (size_t i = 0; i < entering_.size(); ++i) {
    if (i + kAhead < entering_.size())
      for (uint32_t apex : entering_[i + kAhead].apexes)
        if (apex != kNoVertex) fetchTriangles(apex);
    split(entering_[i]);
  }
}

void TerrainPatcher::split(const Entering& entering) {
  const uint32_t v = vertices_.add();
  vertices_.insert(entering.slot, v);
  const NodeId id = entering.id;
  const uint32_t scale = grid_.scaleLog2(id);
  const bool is_on_side = isOnSide(id, scale);
  TerrainVertex vertex;
  vertex.is_used = true;
  vertex.id = id;
  vertex.first_apex = firstApexOf(id, scale);
  const glm::vec2 parameter(static_cast<float>(id.x()), static_cast<float>(id.y()));
  vertex.is_beyond = parameter.x > limit_.x || parameter.y > limit_.y;
  const proto::NodeList<2> apexes = grid_.apexes(id);
  for (int i = 0; i < apexes.count; ++i) {
    const uint32_t found = entering.apexes[static_cast<size_t>(i)],
                   p = found != kNoVertex ? found : placeOf(apexes.ids[i]);
    const NodeId apex = apexes.ids[i];
    const uint32_t corner =
        grid_.isCube() ? cornerOfApex(i, vertex.first_apex, is_on_side) : cornerAt(id, apex, is_on_side);
    const bool is_across = grid_.isOnSeam(id) || grid_.isOnSeam(apex);
    const uint32_t q = is_across ? triangleAcross(apex, id) : triangleOf(corner, is_on_side);
    dropLeaf(p, q);
    TerrainVertex& parent = vertices_[p];
    parent.links[q] = Link::of(Link::Kind::kChild, v);
    vertex.ring[corner] = p;
    vertex.ring[(corner + 1) % 4] = parent.ring[q];
    vertex.ring[(corner + 3) % 4] = parent.ring[(q + 1) % 4];
  }
  vertices_[v] = vertex;
  writer_->addVertex(v, parameter);
  for (uint32_t corner : {uint32_t{vertex.first_apex}, vertex.first_apex + 2u}) {
    if (vertex.ring[corner] == kNoVertex) continue;
    setLeaf(v, corner);
    setLeaf(v, (corner + 3) % 4);
  }
}

// Removes the vertices of those that are in neither section: a node that leaves has no child in the union, once finer
// ones have left.
void TerrainPatcher::mergeUnion(const Slots& slots) {
  const Places places = placesOf(slots);
  for (size_t i = slots.size(); i-- > 0;) {
    if (i >= kAhead) fetchTriangles(places[i - kAhead]);
    if (now().nodes.in(slots[i]) == 0) merge(slots[i], places[i]);
  }
}

void TerrainPatcher::fetchTriangles(uint32_t v) const {
  for (const Link link : vertices_[v].links)
    if (link.kind() == Link::Kind::kTriangle) triangles_.fetch(link.index());
  for (uint32_t corner : vertices_[v].ring)
    if (corner != kNoVertex) vertices_.fetch(corner);
}

void TerrainPatcher::merge(Slot slot, uint32_t v) {
  for (uint32_t q = 0; q < 4; ++q) dropLeaf(v, q);
  for (uint32_t corner : {uint32_t{vertices_[v].first_apex}, vertices_[v].first_apex + 2u}) {
    const uint32_t apex = vertices_[v].ring[corner];
    if (apex == kNoVertex) continue;
    uint32_t q = 0;
    while (vertices_[apex].links[q].bits != Link::of(Link::Kind::kChild, v).bits) ++q;
    setLeaf(apex, q);
  }
  vertices_.erase(slot);
  vertices_.remove(v);
}

void TerrainPatcher::addNormal(uint32_t a, uint32_t b, uint32_t c, double sign) {
  const glm::dvec3 n = sign * face_normal_(vertices_[a].position, vertices_[b].position, vertices_[c].position);
  for (uint32_t v : {a, b, c}) {
    writer_->touchNormal(v);
    vertices_[v].normal += n;
  }
}

// Adds the triangles that the vertex has in the section instead of those that it halves, or takes them away again.
void TerrainPatcher::addHalves(uint32_t v, double sign) {
  const auto ring = vertices_[v].ring;
  for (uint32_t corner : {uint32_t{vertices_[v].first_apex}, vertices_[v].first_apex + 2u}) {
    const uint32_t apex = ring[corner], a = ring[(corner + 1) % 4], b = ring[(corner + 3) % 4];
    if (apex == kNoVertex) continue;
    addNormal(a, b, apex, -sign);
    addNormal(apex, a, v, sign);
    addNormal(b, apex, v, sign);
  }
}

void TerrainPatcher::leaveSection(const Places& removed) {
  for (size_t i = removed.size(); i-- > 0;) {
    if (i >= kAhead) fetchAround(removed[i - kAhead]);
    const uint32_t v = removed[i];
    addHalves(v, -1);
    vertices_[v].is_in_section = false;
    --section_nodes_;
    moving_in_section_ -= vertices_[v].is_true ? 0 : 1;
  }
}

void TerrainPatcher::enterSection(const Slots& added, const Places& places, End end) {
  std::span<const Morph> left = now().morphs.all();
  for (size_t i = 0; i < added.size(); ++i) {
    if (i + kAhead < added.size()) fetchAround(places[i + kAhead]);
    while (!left.empty() && left.front().slot < added[i]) left = left.subspan(1);
    const bool is_morph = !left.empty() && left.front().slot == added[i];
    enter(places[i], drawnAt(places[i], added[i], is_morph ? weightAt(left.front(), end) : 1, end));
  }
}

void TerrainPatcher::enter(uint32_t v, const Move& move) {
  writer_->touchPosition(v);
  writer_->touchNormal(v);
  TerrainVertex& vertex = vertices_[v];
  vertex.moveTo(move.point);
  vertex.is_true = move.is_true;
  vertex.normal = glm::dvec3(0);
  vertex.is_in_section = true;
  ++section_nodes_;
  moving_in_section_ += move.is_true ? 0 : 1;
  addHalves(v, 1);
}

// Vertices that are not in the section lie inside its edges.
void TerrainPatcher::lieOnEdges(const Places& outside) {
  for (size_t i = 0; i < outside.size(); ++i) {
    if (i + kAhead < outside.size()) fetchAround(outside[i + kAhead]);
    const uint32_t v = outside[i];
    writer_->touchPosition(v);
    writer_->touchNormal(v);
    TerrainVertex& vertex = vertices_[v];
    const auto [a, b] = vertex.endpoints();
    vertex.moveTo(0.5 * (vertices_[a].point() + vertices_[b].point()));
    vertex.is_true = false;
    vertex.normal = unitNormal(vertices_[a].unitNormal() + vertices_[b].unitNormal());
  }
}

}  // namespace foreland::client
