// TerrainPatcher's part for vertices that move and stay in the section: nodes in transition by per-node morph timing or
// on curves, nodes with another height, and all that lie between such.
#include <algorithm>
#include <array>
#include <functional>
#include <iterator>

#include "base/check.h"
#include "client/mesh/terrain/curve_bend.h"
#include "client/mesh/terrain/terrain_patcher.h"

namespace foreland::client {

using proto::NodeId;
using proto::Slot;

// Nodes of the section at `end` whose weight may differ from the one that they have now. Without nodes in transition
// all have weight 1.
TerrainPatcher::Slots TerrainPatcher::inTransition(End end) const {
  Slots out;
  for (const Morph& m : now().morphs.all()) {
    const bool changes = end == End::kTo ? m.in == (kInFrom | kInTo) && m.from != m.to
                                         : (m.in & kInFrom) != 0 && (moving_in_section_ > 0 || m.from != 1);
    if (changes) out.push_back(m.slot);
  }
  return out;
}

// The section at `end` before nodes are added to it.
TerrainPatcher::Slots TerrainPatcher::allInSection(End end) const {
  Slots all = now().nodes.newest().slots;
  const auto without = [&](const Slots& added) {
    Slots out;
    std::set_difference(all.begin(), all.end(), added.begin(), added.end(), std::back_inserter(out));
    all.swap(out);
  };
  without(now().morphs.drawn().added);
  if (end == End::kTo) return all;
  Slots from;
  const Slots& removed = now().morphs.drawn().removed;
  std::set_union(all.begin(), all.end(), removed.begin(), removed.end(), std::back_inserter(from));
  all.swap(from);
  without(now().morphs.jumped().added);
  return all;
}

void TerrainPatcher::moveWithin(End end) {
  const bool ground_moves =
      now().heights.isMoving() && scene_time_ != (end == End::kFrom ? now().scene_from : now().scene_to);
  const Slots candidates = ground_moves ? allInSection(end) : inTransition(end);
  if (candidates.empty() && !ground_moves) return;
  move_of_.resize(vertices_.count());
  const bool has_corner = ground_moves && collectBaseMoves(end);
  collectMoves(candidates, end);
  constexpr size_t kFew = 4;  // a star is six triangles, and each is added and subtracted
  if (has_corner || moves_.size() * kFew > vertices_.used()) {
    makeMoves();
    sumAllNormals();
  } else {
    addStars(-1);
    makeMoves();
    addStars(1);
  }
  for (const Move& m : moves_) vertices_[m.vertex].is_moving = false;
  moves_.clear();
}

// False if the vertex is there already.
bool TerrainPatcher::addMove(const Move& move) {
  TerrainVertex& vertex = vertices_[move.vertex];
  if (move.point == vertex.point() && move.is_true == vertex.is_true) return false;
  vertex.is_moving = true;
  move_of_[move.vertex] = static_cast<uint32_t>(moves_.size());
  moves_.push_back(move);
  return true;
}

// Whether a corner of a root moves, whose star is not that of an apex.
bool TerrainPatcher::collectBaseMoves(End end) {
  bool has_corner = false;
  for (uint32_t v = 0; v < baseCount(); ++v) {
    const NodeId id = vertices_[v].id;
    if (addMove({v, truePosition(id, now().nodes.records().height(id), end), true}) && v < cornerCount())
      has_corner = true;
  }
  return has_corner;
}

// Coarse nodes first, so that the endpoints of a node's edge are where they will be.
void TerrainPatcher::collectMoves(const Slots& candidates, End end) {
  Slots heap = candidates, dependents;
  std::make_heap(heap.begin(), heap.end(), std::greater<>{});
  for (Slot last = proto::kNoSlot; !heap.empty();) {
    std::pop_heap(heap.begin(), heap.end(), std::greater<>{});
    const Slot slot = heap.back();
    heap.pop_back();
    if (slot == last) continue;
    last = slot;
    const uint32_t v = vertices_.find(slot);
    if (v == kNoVertex || !vertices_[v].is_in_section) continue;
    const Morph* m = findMorph(now().morphs.all(), slot);
    const Move move = drawnAt(v, slot, m ? weightAt(*m, end) : 1, end);
    if (!addMove(move)) continue;
    if (moving_in_section_ == 0 && move.is_true) continue;  // what lies between true vertices is true itself
    dependents.clear();
    addDependents(v, dependents);
    for (Slot d : dependents) {
      heap.push_back(d);
      std::push_heap(heap.begin(), heap.end(), std::greater<>{});
    }
  }
}

// The nodes of the mesh whose edge ends at the vertex: in eight directions, at ever smaller distances. Where one is
// missing, those that are nearer are, too.
void TerrainPatcher::addDependents(uint32_t v, Slots& out) const {
  const NodeId id = vertices_[v].id;
  if (grid_.isOnSeam(id)) return addDependentsAcross(id, out);
  for (int dy = -1; dy <= 1; ++dy)
    for (int dx = -1; dx <= 1; ++dx) {
      if (dx == 0 && dy == 0) continue;
      for (uint32_t distance = 1u << grid_.scaleLog2(id); distance >>= 1;) {
        const int64_t x = int64_t{id.x()} + dx * int64_t{distance}, y = int64_t{id.y()} + dy * int64_t{distance};
        if (x < 0 || y < 0) break;
        const NodeId n = grid_.nameIn(id.x() >> grid_.shape().root_log2,
                                      NodeId::at(static_cast<uint32_t>(x), static_cast<uint32_t>(y)));
        if (!grid_.contains(n)) break;
        const Slot slot = grid_.slot(n);
        if (vertices_.find(slot) == kNoVertex) break;
        const auto ends = grid_.endpoints(n);
        if (ends[0] == id || ends[1] == id) out.push_back(slot);
      }
    }
}

// The same of a vertex on an edge or a corner of the cube, on each square that holds it. Nodes along edges come twice.
void TerrainPatcher::addDependentsAcross(NodeId id, Slots& out) const {
  const proto::Cube cube = grid_.cube();
  for (const proto::CubePlace& place : cube.placesOf(id))
    for (int dy = -1; dy <= 1; ++dy)
      for (int dx = -1; dx <= 1; ++dx) {
        if (dx == 0 && dy == 0) continue;
        for (int32_t distance = 1 << grid_.scaleLog2(id); distance >>= 1;) {
          const proto::CubePlace there{place.face, place.x + dx * distance, place.y + dy * distance};
          if (!cube.isWithin(there)) break;
          const NodeId n = cube.name(there);
          const Slot slot = grid_.slot(n);
          if (vertices_.find(slot) == kNoVertex) break;
          const auto ends = grid_.endpoints(n);
          if (ends[0] == id || ends[1] == id) out.push_back(slot);
        }
      }
}

DrawnPosition<GroundPoint> TerrainPatcher::willBeAt(uint32_t v) const {
  const TerrainVertex& vertex = vertices_[v];
  if (!vertex.is_moving) return {vertex.point(), vertex.is_true};
  const Move& m = moves_[move_of_[v]];
  return {m.point, m.is_true};
}

GroundPoint TerrainPatcher::displacementOf(uint32_t v, Slot slot, End end) const {
  const std::array<uint32_t, 2> ends = vertices_[v].endpoints();
  const proto::SparseNodes& records = now().nodes.records();
  const auto trueAt = [&](uint32_t u) { return truePosition(vertices_[u].id, records.height(vertices_[u].id), end); };
  return truePosition(vertices_[v].id, records.at(slot).height(), end) - 0.5 * (trueAt(ends[0]) + trueAt(ends[1]));
}

// Nodes in transition bend even where both ends have them at the same place.
void TerrainPatcher::touchCurved() {
  for (const Morph& m : now().morphs.all())
    if (const uint32_t v = vertices_.find(m.slot); v != kNoVertex) writer_->touchPosition(v);
}

// Of the vertices that have been touched, coarse nodes first. Whatever else there is does not bend.
void TerrainPatcher::writeBends(BlendPatch& out) const {
  std::vector<CurveBend> bends(out.positions.size());
  const auto at = [&](uint32_t v) {
    const uint32_t entry = vertices_[v].position_entry;
    return entry == kNoVertex ? CurveBend{} : bends[entry];
  };
  for (const Morph& m : now().morphs.all()) {
    const uint32_t v = vertices_.find(m.slot);
    if (v == kNoVertex) continue;
    const std::array<uint32_t, 2> ends = vertices_[v].endpoints();
    bends[vertices_[v].position_entry] =
        bendOf(at(ends[0]), at(ends[1]), m, now().order, displacementOf(v, m.slot, End::kFrom).position,
               displacementOf(v, m.slot, End::kTo).position);
  }
  cuts_.forEach([&](uint32_t v, uint32_t inside, uint32_t outside, double share) {
    if (vertices_[v].position_entry != kNoVertex)
      bends[vertices_[v].position_entry] = mixOf(at(inside), at(outside), share);
  });
  for (const CurveBend& bend : bends) out.bends.push_back({glm::vec3(bend.from), glm::vec3(bend.to)});
}

// As oracle::MeshBuilder::vertexOf.
TerrainPatcher::Move TerrainPatcher::drawnAt(uint32_t v, Slot slot, double weight, End end) const {
  const std::array<uint32_t, 2> ends = vertices_[v].endpoints();
  const auto own = [&] { return truePosition(vertices_[v].id, now().nodes.records().at(slot).height(), end); };
  const auto displacement = [&] { return displacementOf(v, slot, end); };
  const DrawnPosition<GroundPoint> p = blendPosition(willBeAt(ends[0]), willBeAt(ends[1]), weight, own, displacement);
  return {v, p.position, p.is_true};
}

void TerrainPatcher::makeMoves() {
  for (const Move& m : moves_) {
    writer_->touchPosition(m.vertex);
    TerrainVertex& vertex = vertices_[m.vertex];
    moving_in_section_ += (m.is_true ? 0 : 1);
    moving_in_section_ -= (vertex.is_true ? 0 : 1);
    vertex.moveTo(m.point);
    vertex.is_true = m.is_true;
  }
}

// Each triangle of the section that moves is added once: by its moving corner with the smallest number.
void TerrainPatcher::addStars(double sign) {
  const auto before = [this](uint32_t corner, uint32_t v) { return corner < v && vertices_[corner].is_moving; };
  for (const Move& m : moves_)
    forStar(m.vertex, [&](uint32_t a, uint32_t b, uint32_t c) {
      if (!before(a, m.vertex) && !before(b, m.vertex) && !before(c, m.vertex)) addNormal(a, b, c, sign);
    });
}

void TerrainPatcher::sumAllNormals() {
  const auto isLeaf = [this](Link link) {
    return link.kind() == Link::Kind::kChild ? !vertices_[link.index()].is_in_section
                                             : link.kind() != Link::Kind::kNone;
  };
  for (uint32_t v = 0; v < vertices_.count(); ++v)
    if (vertices_[v].is_used && vertices_[v].is_in_section) {
      writer_->touchNormal(v);
      vertices_[v].normal = glm::dvec3(0);
    }
  for (uint32_t v = 0; v < vertices_.count(); ++v) {
    if (!vertices_[v].is_used || !vertices_[v].is_in_section) continue;
    const std::array<uint32_t, 4> ring = vertices_[v].ring;
    for (uint32_t q = 0; q < 4; ++q)
      if (isLeaf(vertices_[v].links[q])) addNormal(ring[q], ring[(q + 1) % 4], v, 1);
  }
}

// The section's triangles around a node: parts of the four that it is the apex of.
template <class Visit>
void TerrainPatcher::forStar(uint32_t v, const Visit& visit) const {
  for (uint32_t q = 0; q < 4; ++q)
    if (vertices_[v].links[q].kind() != Link::Kind::kNone) forStarWithin(v, v, q, visit);
}

template <class Visit>
void TerrainPatcher::forStarWithin(uint32_t v, uint32_t apex, uint32_t q, const Visit& visit) const {
  const TerrainVertex& vertex = vertices_[apex];
  const uint32_t a = vertex.ring[q], b = vertex.ring[(q + 1) % 4];
  const Link link = vertex.links[q];
  if (link.kind() != Link::Kind::kChild || !vertices_[link.index()].is_in_section) return visit(a, b, apex);
  const TerrainVertex& child = vertices_[link.index()];
  const uint32_t corner = child.ring[child.first_apex] == apex ? child.first_apex : child.first_apex + 2u;
  if (v == apex || v == a) forStarWithin(v, link.index(), corner, visit);
  if (v == apex || v == b) forStarWithin(v, link.index(), (corner + 3) % 4, visit);
}

}  // namespace foreland::client
