#include "oracle/reference/object_mesh.h"

#include <algorithm>
#include <glm/geometric.hpp>
#include <unordered_map>

#include "client/mesh/patch/complete_normals.h"
#include "client/mesh/patch/pack_normal.h"
#include "client/mesh/weights/blend_position.h"
#include "proto/topology/mesh_triangles.h"

namespace foreland::oracle {

using client::BlendMesh;
using client::blendPosition;
using client::completeNormals;
using client::DrawnPosition;
using client::FaceNormal;
using client::findMorph;
using client::KeyframeMesh;
using client::kNoVertex;
using client::Morph;
using client::objectFaceNormal;
using client::ObjectPositions;
using client::packNormal;
using client::parameterLayout;
using proto::NodeId;
using proto::Slot;

namespace {

// The nodes that are in one of some sections, as a bit for each slot up to the largest. Coarse levels have the small
// slots, so it is short where an object is far away; at most 8 MB (ObjectSet::kMaxSlots).
class SlotSet {
 public:
  void insert(const proto::Section& section) {
    if (section.slots.empty()) return;
    words_.resize(std::max<size_t>(words_.size(), section.slots.back() / 64 + 1));
    for (Slot slot : section.slots) words_[slot / 64] |= uint64_t{1} << slot % 64;
  }
  bool has(Slot slot) const { return slot / 64 < words_.size() && (words_[slot / 64] >> slot % 64 & 1) != 0; }

 private:
  std::vector<uint64_t> words_;
};

// Makes vertices as the triangles of the union name them. A vertex is a base vertex, a node of either section, or the
// midpoint of an edge where a neighbour is split (S 3.6). Where it is no node of an end's section it lies between its
// endpoints.
class Builder {
 public:
  Builder(const proto::ObjectSet& objects, const ObjectPositions& positions, const ObjectSections& sections,
          ObjectMesh& out)
      : positions_(positions),
        sections_(sections),
        mesh_(objects.domain(positions.object).topology()),
        model_(objects.modelOf(positions.object)),
        placement_(objects.placement(positions.object)),
        layout_(parameterLayout(mesh_.base().faceCount(), model_.atlas_side)),
        scale_(mesh_.weightScale()),
        face_normal_(objectFaceNormal(model_)),
        out_(out) {
    in_from_.insert(sections.from);
    in_to_.insert(sections.to);
    in_either_.insert(sections.from);
    in_either_.insert(sections.to);
  }

  void run() {
    const auto isInFrom = [this](NodeId n) { return in_from_.has(mesh_.slot(n)); };
    const auto isInTo = [this](NodeId n) { return in_to_.has(mesh_.slot(n)); };
    const auto isInEither = [this](NodeId n) { return in_either_.has(mesh_.slot(n)); };
    for (uint32_t face = 0; face < mesh_.base().faceCount(); ++face) {
      corners_.clear();
      const auto draw = [&](NodeId a, NodeId b, NodeId c) {
        for (NodeId v : {a, b, c}) out_.indices.push_back(corner(face, v));
      };
      proto::forEachTriangleOf(mesh_, face, isInEither, draw);
    }
    for (auto& normals : normal_) normals.resize(endpoints_.size(), glm::dvec3(0));
    for (auto& is_vertex : is_vertex_) is_vertex.resize(endpoints_.size());
    proto::forEachTriangle(mesh_, isInFrom, [this](NodeId a, NodeId b, NodeId c) { addNormal(0, a, b, c); });
    proto::forEachTriangle(mesh_, isInTo, [this](NodeId a, NodeId b, NodeId c) { addNormal(1, a, b, c); });
    finish();
  }

 private:
  std::array<double, 2> weights(NodeId n) const {
    if (const Morph* m = findMorph(sections_.morphs, mesh_.slot(n))) return {m->from, m->to};
    const double weight = proto::contains(sections_.newest, mesh_.slot(n)) ? 1 : 0;
    return {weight, weight};
  }

  uint32_t vertex(NodeId v) {
    if (const auto it = vertex_of_.find(v); it != vertex_of_.end()) return it->second;
    if (mesh_.isBase(v))
      return add(v, {kNoVertex, kNoVertex}, {{{positions_.at(v, 0), true}, {positions_.at(v, 1), true}}});
    const std::array<NodeId, 2> names = mesh_.endpoints(v);
    const std::array<uint32_t, 2> endpoints{vertex(names[0]), vertex(names[1])};
    const std::array<double, 2> weight = weights(v);
    std::array<DrawnPosition<glm::dvec3>, 2> drawn;
    for (size_t s = 0; s < 2; ++s) {
      const auto drawnAt = [&](uint32_t end) {
        return DrawnPosition<glm::dvec3>{out_.position[s][end], is_true_[s][end] != 0};
      };
      drawn[s] = blendPosition(
          drawnAt(endpoints[0]), drawnAt(endpoints[1]), weight[s], [&] { return positions_.at(v, s); },
          [&] { return positions_.at(v, s) - 0.5 * (positions_.at(names[0], s) + positions_.at(names[1], s)); });
    }
    return add(v, endpoints, drawn);
  }

  uint32_t add(NodeId v, const std::array<uint32_t, 2>& endpoints,
               const std::array<DrawnPosition<glm::dvec3>, 2>& drawn) {
    for (size_t s = 0; s < 2; ++s) {
      out_.position[s].push_back(drawn[s].position);
      is_true_[s].push_back(drawn[s].is_true);
    }
    endpoints_.push_back(endpoints);
    return vertex_of_[v] = static_cast<uint32_t>(endpoints_.size() - 1);
  }

  // The vertex as the face has it.
  uint32_t corner(uint32_t face, NodeId v) {
    const auto [it, is_new] = corners_.try_emplace(v, static_cast<uint32_t>(out_.corners.size()));
    if (is_new) {
      const proto::FacePoint point = mesh_.facePointIn(face, v);
      const glm::dvec3 weights(point.weights[0], point.weights[1], point.weights[2]);
      out_.corners.push_back({vertex(v), glm::vec2(layout_.coordinates(face, weights / scale_))});
    }
    return it->second;
  }

  void addNormal(size_t s, NodeId a, NodeId b, NodeId c) {
    const std::array<uint32_t, 3> corner{vertex_of_.at(a), vertex_of_.at(b), vertex_of_.at(c)};
    const auto& p = out_.position[s];
    const glm::dvec3 n = face_normal_(p[corner[0]], p[corner[1]], p[corner[2]]);
    for (uint32_t v : corner) {
      normal_[s][v] += n;
      is_vertex_[s][v] = 1;
    }
  }

  // Until here all is in the object's frame.
  void finish() {
    for (size_t s = 0; s < 2; ++s) {
      completeNormals(
          endpoints_.size(), [&](size_t v) { return is_vertex_[s][v] != 0; }, [&](size_t v) { return endpoints_[v]; },
          [&](size_t v) -> glm::dvec3& { return normal_[s][v]; });
      for (const glm::dvec3& n : normal_[s]) out_.normal[s].push_back(packNormal(placement_.orientation * n));
      for (glm::dvec3& p : out_.position[s]) p = placement_.toScene(p) + sections_.carried[s];
    }
  }

  const ObjectPositions& positions_;
  const ObjectSections& sections_;
  const proto::MeshTopology& mesh_;
  const proto::ObjectModel& model_;
  const proto::ObjectPlacement& placement_;
  const proto::AtlasLayout layout_;
  const double scale_;
  const FaceNormal face_normal_;
  ObjectMesh& out_;
  SlotSet in_from_, in_to_, in_either_;
  std::unordered_map<NodeId, uint32_t> vertex_of_;
  std::unordered_map<NodeId, uint32_t> corners_;    // of the face at hand
  std::vector<std::array<uint32_t, 2>> endpoints_;  // by vertex
  std::array<std::vector<uint8_t>, 2> is_true_;     // by vertex: it is drawn at its true position
  std::array<std::vector<uint8_t>, 2> is_vertex_;   // by vertex: it is a corner of the triangles of that end's section
  std::array<std::vector<glm::dvec3>, 2> normal_;
};

}  // namespace

ObjectMesh buildObjectMesh(const proto::ObjectSet& objects, const ObjectPositions& positions,
                           const ObjectSections& sections) {
  ObjectMesh mesh;
  Builder(objects, positions, sections, mesh).run();
  return mesh;
}

void ObjectMesh::appendTo(KeyframeMesh& mesh, uint32_t model) const {
  BlendMesh& out = mesh.objects;
  const auto first = static_cast<uint32_t>(out.from_positions.size());
  for (const Corner& c : corners) {
    out.from_positions.emplace_back(glm::vec3(position[0][c.vertex] - mesh.origin), 0.0f);
    out.to_positions.emplace_back(glm::vec3(position[1][c.vertex] - mesh.origin), 0.0f);
    out.from_normals.push_back(normal[0][c.vertex]);
    out.to_normals.push_back(normal[1][c.vertex]);
    out.parameters.push_back(c.texture_coordinate);
  }
  mesh.object_parts.push_back(
      {static_cast<uint32_t>(out.indices.size()), static_cast<uint32_t>(indices.size()), model});
  for (uint32_t corner : indices) out.indices.push_back(first + corner);
}

}  // namespace foreland::oracle
