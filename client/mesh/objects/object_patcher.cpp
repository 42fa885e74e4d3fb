#include "client/mesh/objects/object_patcher.h"

#include <algorithm>

#include "base/sort.h"
#include "client/mesh/patch/pack_normal.h"
#include "client/mesh/weights/blend_position.h"
#include "proto/topology/mesh_triangles.h"

namespace foreland::client {

using proto::NodeId;
using proto::Slot;

namespace {

// Calls visit(face) for each base face that holds the node, inside or on its border.
template <class Visit>
void forEachFaceOf(const proto::MeshTopology& mesh, NodeId n, const Visit& visit) {
  const proto::PatchPoint p = proto::patchPointOf(n);
  if (mesh.rule() == proto::MeshRule::kQuadrisection) {
    for (const proto::PatchPoint& at : mesh.quad().appearances(p)) visit(at.patch);
    return;
  }
  const proto::HalfEdge first = mesh.base().first(p.patch), second = mesh.base().twin(first);
  if (p.x <= p.y) visit(proto::BaseMesh::face(first));
  if (p.x >= p.y && second != proto::kNoHalfEdge) visit(proto::BaseMesh::face(second));
}

}  // namespace

ObjectPatcher::ObjectPatcher(const proto::ObjectSet& objects, size_t object)
    : objects_(&objects),
      object_(object),
      face_normal_(objectFaceNormal(objects.modelOf(object))),
      layout_(
          parameterLayout(objects.domain(object).topology().base().faceCount(), objects.modelOf(object).atlas_side)) {}

void ObjectPatcher::step(const ObjectPositions& positions, const Morphs& morphs, const Carried& carried) {
  clearChanges();
  carry(carried);
  ++steps_;
  positions_ = &positions, morphs_ = morphs.all();
  is_posed_ = poses_ != positions.weights || poses_[0] != poses_[1];
  poses_ = positions.weights;
  collectFaces(morphs);
  for (const ChangingFace& c : changing_) addNormals(c.face, -1);
  stepSections(morphs);
  for (const ChangingFace& c : changing_) update(c);
  dropCorners();
  for (size_t i = 0; i < seen_.size(); ++i) move(seen_[i].vertex);
  for (const ChangingFace& c : changing_) addNormals(c.face, 1);
  for (const Seen& seen : seen_) note(seen);
  dropVertices();
  for (uint32_t corner : added_) corners_[corner].is_new = false;
  finishTriangles();
  positions_ = nullptr, morphs_ = {};
  seen_.clear(), changing_.clear();
}

void ObjectPatcher::rest(const Carried& carried) {
  clearChanges();
  carry(carried);
  is_whole_ = false;
}

void ObjectPatcher::clearChanges() { moved_.clear(), turned_.clear(), added_.clear(), changed_.clear(); }

void ObjectPatcher::carry(const Carried& carried) {
  is_carried_ = carried != carried_;
  carried_ = carried;
}

uint8_t ObjectPatcher::in(NodeId n) const {
  const uint32_t found = vertex_of_.find(objects_->domain(object_).topology().slot(n));
  return found == 0 ? 0 : vertices_[found - 1].in;
}

// A face's triangles depend on the nodes that it holds and, by quadrisection, on those of the triangles beyond its
// border (mesh_triangles.h).
void ObjectPatcher::collectFaces(std::span<const Slot> slots, Change change) {
  const proto::MeshTopology& mesh = objects_->domain(object_).topology();
  const auto add = [&](uint32_t face) { changing_.push_back({face, change}); };
  for (Slot slot : slots) {
    const NodeId n = mesh.node(slot);
    forEachFaceOf(mesh, n, add);
    if (mesh.rule() == proto::MeshRule::kQuadrisection)
      for (NodeId sibling : mesh.quad().siblings(proto::patchPointOf(n))) forEachFaceOf(mesh, sibling, add);
  }
}

// The base vertices, and all faces as ones that change.
void ObjectPatcher::addBase() {
  const proto::MeshTopology& mesh = objects_->domain(object_).topology();
  faces_.resize(mesh.base().faceCount());
  for (uint32_t v = 0; v < mesh.baseVertexCount(); ++v) {
    const proto::NodeId id = proto::baseVertexId(v);
    vertices_.push_back(
        {.id = id, .position = {positions_->at(id, 0), positions_->at(id, 1)}, .is_true = {true, true}});
  }
  for (uint32_t face = 0; face < faces_.size(); ++face) changing_.push_back({face, kJumps});
}

void ObjectPatcher::collectFaces(const Morphs& morphs) {
  if (faces_.empty()) addBase();
  if (is_posed_)
    for (uint32_t face = 0; face < faces_.size(); ++face) changing_.push_back({face, kMoves});
  collectFaces(in_transition_, kMoves);
  in_transition_.clear();
  for (const Morph& m : morphs_) in_transition_.push_back(m.slot);
  collectFaces(in_transition_, kMoves);
  collectFaces(morphs.drawn().added, kGrows);
  collectFaces(morphs.drawn().removed, kShrinks);
  for (const auto* slots : {&morphs.jumped().added, &morphs.jumped().removed}) collectFaces(*slots, kJumps);
  foreland::sort(changing_.begin(), changing_.end(), [](const auto& a, const auto& b) { return a.face < b.face; });
  size_t kept = 0;
  for (const ChangingFace& c : changing_) {
    if (kept > 0 && changing_[kept - 1].face == c.face)
      changing_[kept - 1].changes |= c.changes;
    else
      changing_[kept++] = c;
  }
  changing_.resize(kept);
}

// What was `to` becomes `from`, and changes by what jumps; `to` is that with what the interval adds and removes.
void ObjectPatcher::stepSections(const Morphs& morphs) {
  const proto::MeshTopology& mesh = objects_->domain(object_).topology();
  const auto set = [&](const std::vector<Slot>& slots, uint8_t bits, bool is_in) {
    for (Slot slot : slots) {
      const uint32_t v = vertexOf(mesh.node(slot));
      setSections(v, static_cast<uint8_t>(is_in ? vertices_[v].in | bits : vertices_[v].in & ~bits));
    }
  };
  for (Slot slot : differing_) setSections(placeOf(slot), vertices_[placeOf(slot)].in & kInTo ? kInFrom | kInTo : 0);
  set(morphs.jumped().removed, kInFrom | kInTo, false);
  set(morphs.jumped().added, kInFrom | kInTo, true);
  set(morphs.drawn().removed, kInTo, false);
  set(morphs.drawn().added, kInTo, true);
  differing_ = morphs.drawn().added;
  differing_.insert(differing_.end(), morphs.drawn().removed.begin(), morphs.drawn().removed.end());
  const auto finest = std::find_if(nodes_.begin(), nodes_.end(), [](uint32_t count) { return count > 0; });
  finest_ = 1 << (finest - nodes_.begin());
}

void ObjectPatcher::setSections(uint32_t v, uint8_t in) {
  Vertex& vertex = vertices_[v];
  uint32_t& count = nodes_[proto::patchPointOf(vertex.id).scaleLog2()];
  count += in != 0 ? 1 : 0;
  count -= vertex.in != 0 ? 1 : 0;
  vertex.in = in;
  if (in == 0) perhaps_unused_.push_back(v);
}

uint32_t ObjectPatcher::vertexOf(NodeId v) {
  const proto::MeshTopology& mesh = objects_->domain(object_).topology();
  if (mesh.isBase(v)) return proto::baseVertexOf(v);
  const uint32_t found = vertex_of_.find(mesh.slot(v));
  return found != 0 ? found - 1 : addNode(v);
}

uint32_t ObjectPatcher::addNode(NodeId v) {
  const proto::MeshTopology& mesh = objects_->domain(object_).topology();
  Vertex vertex{.id = v, .slot = mesh.slot(v)};
  for (size_t i = 0; i < 2; ++i) vertex.endpoints[i] = vertexOf(mesh.endpoints(v)[i]);
  const uint32_t place = takePlace(vertices_, free_vertices_);
  vertices_[place] = vertex;
  vertex_of_.insert(vertex.slot, place + 1);
  perhaps_unused_.push_back(place);
  return place;
}

// Brings the face's triangles up to date: those of both ends' union, and those of either end where these differ. Where
// nothing jumps, a mesh begins with what the last one ended with.
void ObjectPatcher::update(const ChangingFace& changing) {
  const auto [face, changes] = changing;
  const auto last = ends_.find(face);
  from_.clear();
  if ((changes & kJumps) != 0)
    cut(face, kInFrom, from_);
  else if (last != ends_.end())
    from_ = last->second[1];
  else
    for (const Triangle& t : faces_[face]) from_.push_back(t.vertices);
  const bool grows = (changes & kGrows) != 0, shrinks = (changes & kShrinks) != 0;
  if (grows)
    cut(face, kInFrom | kInTo, now_);
  else
    now_ = from_;
  if (shrinks) cut(face, kInTo, to_);
  if (grows || shrinks)
    ends_[face] = {from_, shrinks ? to_ : now_};
  else if (last != ends_.end())
    ends_.erase(last);
  replace(face);
}

// The face's triangles of these sections' union.
void ObjectPatcher::cut(uint32_t face, uint8_t sections, std::vector<Corners>& out) {
  out.clear();
  const auto draw = [&](NodeId a, NodeId b, NodeId c) { out.push_back({vertexOf(a), vertexOf(b), vertexOf(c)}); };
  proto::forEachTriangleOf(objects_->domain(object_).topology(), face, InSections{*this, sections}, draw);
}

// Triangles that the face had before keep their places.
void ObjectPatcher::replace(uint32_t face) {
  foreland::sort(now_.begin(), now_.end());
  was_.swap(faces_[face]);
  std::vector<Triangle>& triangles = faces_[face];
  triangles.clear();
  triangles.reserve(now_.size());
  auto old = was_.begin();
  for (const Corners& vertices : now_) {
    for (uint32_t v : vertices) see(v);
    while (old != was_.end() && old->vertices < vertices) removeTriangle(face, *old++);
    const bool is_old = old != was_.end() && old->vertices == vertices;
    triangles.push_back(is_old ? *old++ : Triangle{vertices, kNoVertex});
  }
  while (old != was_.end()) removeTriangle(face, *old++);
  for (Triangle& t : triangles)
    if (t.place == kNoVertex) addTriangle(face, t);
}

void ObjectPatcher::addTriangle(uint32_t face, Triangle& triangle) {
  Corners corners{};
  for (size_t i = 0; i < 3; ++i) {
    corners[i] = cornerOf(face, triangle.vertices[i]);
    if (corners[i] == kNoVertex) corners[i] = addCorner(face, triangle.vertices[i]);
    ++corners_[corners[i]].triangles;
  }
  triangle.place = triangles_.add(corners, face);
}

void ObjectPatcher::removeTriangle(uint32_t face, const Triangle& triangle) {
  for (uint32_t v : triangle.vertices) {
    const uint32_t corner = cornerOf(face, v);
    if (--corners_[corner].triangles == 0) unused_corners_.push_back(corner);
  }
  triangles_.remove(triangle.place);
}

uint32_t ObjectPatcher::cornerOf(uint32_t face, uint32_t v) const {
  uint32_t corner = vertices_[v].first_corner;
  while (corner != kNoVertex && corners_[corner].face != face) corner = corners_[corner].next;
  return corner;
}

uint32_t ObjectPatcher::addCorner(uint32_t face, uint32_t v) {
  const proto::MeshTopology& mesh = objects_->domain(object_).topology();
  const proto::FacePoint point = mesh.facePointIn(face, vertices_[v].id);
  const glm::dvec3 weights(point.weights[0], point.weights[1], point.weights[2]);
  const glm::vec2 coordinate(layout_.coordinates(face, weights / static_cast<double>(mesh.weightScale())));
  const uint32_t corner = takePlace(corners_, free_corners_);
  corners_[corner] = {v, face, vertices_[v].first_corner, 0, coordinate, true};
  vertices_[v].first_corner = corner;
  added_.push_back(corner);
  return corner;
}

// A corner may have got other triangles since it lost its last one.
void ObjectPatcher::dropCorners() {
  for (uint32_t corner : unused_corners_) {
    Corner& unused = corners_[corner];
    if (unused.triangles > 0 || unused.face == kNoVertex) continue;
    uint32_t* link = &vertices_[unused.vertex].first_corner;
    while (*link != corner) link = &corners_[*link].next;
    *link = unused.next;
    perhaps_unused_.push_back(unused.vertex);
    unused.face = kNoVertex;
    free_corners_.push_back(corner);
  }
  unused_corners_.clear();
}

void ObjectPatcher::see(uint32_t v) {
  Vertex& vertex = vertices_[v];
  if (vertex.seen == steps_) return;
  vertex.seen = steps_;
  seen_.push_back({v, vertex.position[1], vertex.packed[1]});
}

// To where it is drawn at the mesh's ends, its endpoints first.
void ObjectPatcher::move(uint32_t v) {
  const Vertex& vertex = vertices_[v];
  if (vertex.moved == steps_) return;
  if (vertex.endpoints[0] == kNoVertex) return moveBase(v);
  for (uint32_t end : vertex.endpoints) move(end);
  const Morph* m = findMorph(morphs_, vertex.slot);
  const std::array<double, 2> weights = m ? std::array{m->from, m->to} : weightsOf(vertex.in);
  for (size_t s = 0; s < 2; ++s) {
    const auto drawn = [&](uint32_t u) {
      return DrawnPosition<glm::dvec3>{vertices_[u].position[s], vertices_[u].is_true[s]};
    };
    const auto own = [&] {
      return vertex.is_true[1] && !is_posed_ ? vertex.position[1] : positions_->at(vertex.id, s);
    };
    const auto displacement = [&] {
      const auto [a, b] = vertex.endpoints;
      return own() - 0.5 * (positions_->at(vertices_[a].id, s) + positions_->at(vertices_[b].id, s));
    };
    const DrawnPosition<glm::dvec3> p =
        blendPosition(drawn(vertex.endpoints[0]), drawn(vertex.endpoints[1]), weights[s], own, displacement);
    vertices_[v].position[s] = p.position;
    vertices_[v].is_true[s] = p.is_true;
  }
  vertices_[v].moved = steps_;
}

void ObjectPatcher::moveBase(uint32_t v) {
  Vertex& vertex = vertices_[v];
  if (is_posed_)
    for (size_t s = 0; s < 2; ++s) vertex.position[s] = positions_->at(vertex.id, s);
  vertex.moved = steps_;
}

// The face's triangles join the sums of their vertices, or leave them.
void ObjectPatcher::addNormals(uint32_t face, double sign) {
  const auto add = [&](size_t s, const Corners& t) {
    const glm::dvec3 n =
        sign * face_normal_(vertices_[t[0]].position[s], vertices_[t[1]].position[s], vertices_[t[2]].position[s]);
    for (uint32_t v : t) {
      vertices_[v].normal[s] += n;
      vertices_[v].triangles[s] += sign > 0 ? 1u : ~0u;
    }
  };
  const auto ends = ends_.find(face);
  for (size_t s = 0; s < 2; ++s) {
    if (ends != ends_.end())
      for (const Corners& t : ends->second[s]) add(s, t);
    else
      for (const Triangle& t : faces_[face]) add(s, t.vertices);
  }
}

// As completeNormals.
glm::dvec3 ObjectPatcher::unitNormalOf(uint32_t v, size_t end) const {
  const Vertex& vertex = vertices_[v];
  if (vertex.triangles[end] > 0) return unitNormal(vertex.normal[end]);
  return unitNormal(unitNormalOf(vertex.endpoints[0], end) + unitNormalOf(vertex.endpoints[1], end));
}

void ObjectPatcher::note(const Seen& seen) {
  Vertex& vertex = vertices_[seen.vertex];
  const glm::dquat& orientation = objects_->placement(object_).orientation;
  for (size_t s = 0; s < 2; ++s) vertex.packed[s] = packNormal(orientation * unitNormalOf(seen.vertex, s));
  const bool moves = vertex.position[0] != seen.position || vertex.position[1] != seen.position,
             turns = vertex.packed[0] != seen.packed || vertex.packed[1] != seen.packed;
  for (uint32_t c = vertex.first_corner; c != kNoVertex; c = corners_[c].next) {
    if (corners_[c].is_new) continue;
    if (moves) moved_.push_back(c);
    if (turns) turned_.push_back(c);
  }
}

void ObjectPatcher::dropVertices() {
  for (uint32_t v : perhaps_unused_) {
    const Vertex& vertex = vertices_[v];
    if (vertex.in != 0 || vertex.first_corner != kNoVertex || vertex.endpoints[0] == kNoVertex) continue;
    if (vertex_of_.find(vertex.slot) != v + 1) continue;
    vertex_of_.erase(vertex.slot);
    free_vertices_.push_back(v);
  }
  perhaps_unused_.clear();
}

void ObjectPatcher::finishTriangles() {
  const auto moved = [this](uint32_t face, uint32_t from, uint32_t to) {
    for (Triangle& t : faces_[face])
      if (t.place == from) t.place = to;
  };
  triangles_.finish(moved, changed_);
  is_whole_ = corners_.size() > 2 * (corners_.size() - free_corners_.size()) + kFewCorners;
  if (is_whole_) compact();
}

// Corners become as many as are in use.
void ObjectPatcher::compact() {
  for (Vertex& vertex : vertices_) vertex.first_corner = kNoVertex;
  corners_.clear(), free_corners_.clear();
  triangles_ = {};
  for (uint32_t face = 0; face < faces_.size(); ++face)
    for (Triangle& t : faces_[face]) addTriangle(face, t);
  for (Corner& c : corners_) c.is_new = false;
  clearChanges();
  triangles_.finish([](uint32_t, uint32_t, uint32_t) {}, changed_);
}

BlendPatch::Position ObjectPatcher::positionOf(uint32_t corner, const glm::dvec3& origin) const {
  const Vertex& vertex = vertices_[corners_[corner].vertex];
  const auto at = [&](size_t s) { return glm::vec4(glm::vec3(sceneAt(vertex, s) - origin), 0.0f); };
  return {corner, at(0), at(1)};
}

BlendPatch::Normal ObjectPatcher::normalOf(uint32_t corner) const {
  const Vertex& vertex = vertices_[corners_[corner].vertex];
  return {corner, vertex.packed[0], vertex.packed[1]};
}

void ObjectPatcher::write(const glm::dvec3& origin, BlendPatch& out) const {
  const auto writePositions = [&](const std::vector<uint32_t>& corners) {
    for (uint32_t c : corners) out.positions.push_back(positionOf(c, origin));
  };
  const auto writeNormals = [&](const std::vector<uint32_t>& corners) {
    for (uint32_t c : corners) out.normals.push_back(normalOf(c));
  };
  if (is_carried_) {
    for (uint32_t c = 0; c < vertexCount(); ++c)
      if (corners_[c].triangles > 0) out.positions.push_back(positionOf(c, origin));
  } else {
    writePositions(moved_);
    writePositions(added_);
  }
  writeNormals(turned_);
  writeNormals(added_);
  for (uint32_t c : added_) out.parameters.push_back({c, corners_[c].texture_coordinate});
  out.triangles.insert(out.triangles.end(), changed_.triangles.begin(), changed_.triangles.end());
}

void ObjectPatcher::writeAll(const glm::dvec3& origin, BlendPatch& out) const {
  for (uint32_t c = 0; c < vertexCount(); ++c) {
    if (corners_[c].triangles == 0) continue;
    out.positions.push_back(positionOf(c, origin));
    out.normals.push_back(normalOf(c));
    out.parameters.push_back({c, corners_[c].texture_coordinate});
  }
  for (uint32_t face = 0; face < faces_.size(); ++face)
    for (const Triangle& t : faces_[face])
      out.triangles.push_back(
          {t.place, {cornerOf(face, t.vertices[0]), cornerOf(face, t.vertices[1]), cornerOf(face, t.vertices[2])}});
}

bool ObjectPatcher::findEnd(NodeId v, glm::dvec3& position, uint32_t& normal) const {
  const proto::MeshTopology& mesh = objects_->domain(object_).topology();
  const uint32_t found = mesh.isBase(v) ? proto::baseVertexOf(v) + 1 : vertex_of_.find(mesh.slot(v));
  if (found == 0 || found > vertices_.size()) return false;
  const Vertex& vertex = vertices_[found - 1];
  position = sceneAt(vertex, 1);
  normal = vertex.packed[1];
  return true;
}

size_t ObjectPatcher::bytes() const {
  size_t triangles = 0;
  for (const Face& face : faces_) triangles += face.capacity();
  return vertices_.capacity() * sizeof(Vertex) + corners_.capacity() * sizeof(Corner) + triangles_.bytes() +
         faces_.capacity() * sizeof(Face) + triangles * sizeof(Triangle) + vertex_of_.bytes();
}

}  // namespace foreland::client
