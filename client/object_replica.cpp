#include "client/object_replica.h"

#include <algorithm>
#include <glm/geometric.hpp>
#include <utility>

#include "client/blend_position.h"
#include "client/pack_normal.h"
#include "client/settle_normals.h"
#include "proto/topology/mesh_triangles.h"

namespace foreland::client {

using proto::NodeId;
using proto::Slot;

namespace {

// Which nodes are in one of some sections, to be asked often: a bit for each slot up to the largest. Coarse levels come
// first, so it is small where an object is far; 8 MB at most (ObjectSet::kMaxSlots).
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

}  // namespace

// Numbers vertices as the triangles of the union name them. A vertex is a base vertex, a node of either section, or the
// middle of an edge where a neighbour is split (S 3.6); where it is no node of a section it lies between its endpoints.
class ObjectReplica::Builder {
 public:
  Builder(const ObjectReplica& replica, const proto::ObjectStream& stream, Vertices& out)
      : replica_(replica),
        stream_(stream),
        mesh_(replica.objects_->domain(replica.object_).topology()),
        model_(replica.objects_->modelOf(replica.object_)),
        atlas_(replica.objects_->atlasOf(replica.object_)),
        scale_(mesh_.placeScale()),
        out_(out) {
    in_from_.insert(replica.from_);
    in_to_.insert(replica.to_);
    in_either_.insert(replica.from_);
    in_either_.insert(replica.to_);
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
    for (auto& normals : normal_) normals.resize(ends_.size(), glm::dvec3(0));
    proto::forEachTriangle(mesh_, isInFrom, [this](NodeId a, NodeId b, NodeId c) { addNormal(0, a, b, c); });
    proto::forEachTriangle(mesh_, isInTo, [this](NodeId a, NodeId b, NodeId c) { addNormal(1, a, b, c); });
    finish();
  }

 private:
  glm::dvec3 own(NodeId v) const {
    if (mesh_.isBase(v)) return glm::dvec3(model_.base[proto::baseVertexOf(v)]) * model_.step_m;
    return glm::dvec3(replica_.stepsOf(stream_, mesh_.slot(v))) * model_.step_m;
  }
  std::array<double, 2> weights(NodeId n) const {
    if (const Morph* m = findMorph(replica_.morphs_.all(), mesh_.slot(n))) return {m->from, m->to};
    const double weight = proto::contains(replica_.section_, mesh_.slot(n)) ? 1 : 0;
    return {weight, weight};
  }

  uint32_t vertex(NodeId v) {
    if (const auto it = out_.numbers.find(v); it != out_.numbers.end()) return it->second;
    if (mesh_.isBase(v)) return add(v, {kNoEnd, kNoEnd}, {{{own(v), true}, {own(v), true}}});
    const std::array<NodeId, 2> names = mesh_.endpoints(v);
    const std::array<uint32_t, 2> ends{vertex(names[0]), vertex(names[1])};
    const std::array<double, 2> weight = weights(v);
    std::array<Drawn<glm::dvec3>, 2> at;
    for (size_t s = 0; s < 2; ++s) {
      const auto drawn = [&](uint32_t end) { return Drawn<glm::dvec3>{out_.position[s][end], is_own_[s][end] != 0}; };
      at[s] = blendPosition(
          drawn(ends[0]), drawn(ends[1]), weight[s], [&] { return own(v); },
          [&] { return own(v) - 0.5 * (own(names[0]) + own(names[1])); });
    }
    return add(v, ends, at);
  }

  uint32_t add(NodeId v, const std::array<uint32_t, 2>& ends, const std::array<Drawn<glm::dvec3>, 2>& at) {
    for (size_t s = 0; s < 2; ++s) {
      out_.position[s].push_back(at[s].at);
      is_own_[s].push_back(at[s].is_own);
    }
    ends_.push_back(ends);
    return out_.numbers[v] = static_cast<uint32_t>(ends_.size() - 1);
  }

  // The vertex as the face has it.
  uint32_t corner(uint32_t face, NodeId v) {
    const auto [at, is_new] = corners_.try_emplace(v, static_cast<uint32_t>(out_.corners.size()));
    if (is_new) {
      const proto::FacePoint place = mesh_.placeIn(face, v);
      const glm::dvec3 weights(place.weights[0], place.weights[1], place.weights[2]);
      out_.corners.push_back(
          {vertex(v), atlas_.side > 0 ? glm::vec2(atlas_.coordinates(face, weights / scale_)) : glm::vec2(0)});
    }
    return at->second;
  }

  void addNormal(size_t s, NodeId a, NodeId b, NodeId c) {
    const std::array<uint32_t, 3> corner{out_.numbers.at(a), out_.numbers.at(b), out_.numbers.at(c)};
    const auto& p = out_.position[s];
    const glm::dvec3 n = glm::cross(p[corner[1]] - p[corner[0]], p[corner[2]] - p[corner[0]]);
    for (uint32_t v : corner) normal_[s][v] += n;
  }

  void finish() {
    const proto::ObjectPlacement& placement = replica_.objects_->placement(replica_.object_);
    for (size_t s = 0; s < 2; ++s) {
      settleNormals(
          ends_.size(), [&](size_t v) { return ends_[v]; }, [&](size_t v) -> glm::dvec3& { return normal_[s][v]; });
      for (const glm::dvec3& n : normal_[s]) out_.normal[s].push_back(packNormal(placement.orientation * n));
      for (glm::dvec3& p : out_.position[s]) p = placement.toScene(p);
    }
  }

  const ObjectReplica& replica_;
  const proto::ObjectStream& stream_;
  const proto::MeshTopology& mesh_;
  const proto::ObjectModel& model_;
  const proto::AtlasLayout atlas_;
  const double scale_;
  Vertices& out_;
  SlotSet in_from_, in_to_, in_either_;
  std::unordered_map<NodeId, uint32_t> corners_;  // of the face at hand
  std::vector<std::array<uint32_t, 2>> ends_;     // of each vertex's edge
  std::array<std::vector<uint8_t>, 2> is_own_;    // each is drawn at its own place
  std::array<std::vector<glm::dvec3>, 2> normal_;
};

ObjectReplica::ObjectReplica(const proto::ObjectSet& objects, size_t object) : objects_(&objects), object_(object) {}

bool ObjectReplica::step(proto::ObjectStream& stream, proto::RangeDecoder& coder, uint32_t& fingerprint) {
  delta_.added.clear();
  delta_.removed.clear();
  if (!stream.decode(object_, coder, delta_)) return false;
  for (Slot slot : delta_.removed) gone_[slot] = stream.position(object_, slot);
  fingerprint += proto::fingerprintOf(object_, delta_);
  return true;
}

// No mesh may have been made of what the last step has told.
void ObjectReplica::blend(const MeshSpan& span, const proto::ObjectStream& stream) {
  proto::Section section = stream.section(object_);
  proto::diff(section_, section, delta_);
  section_ = std::move(section);
  const proto::ObjectPlacement& placement = objects_->placement(object_);
  const proto::View from = placement.toObject(span.from);
  const MorphClock clock(span, from, span.motion.metres_per_s / placement.scale);
  morphs_.step(objects_->domain(object_).topology(), delta_, [&](Slot slot) {
    return !clock.isEven() && facesAway(span.from, slot) ? 0 : intervals(clock, stream, slot);
  });
  from_ = proto::apply(to_, morphs_.jumped());
  to_ = proto::apply(from_, morphs_.drawn());
  const bool was_still = std::exchange(is_still_, morphs_.all().empty());
  if (was_still && is_still_ && !vertices_.indices.empty()) return;
  vertices_ = {};
  Builder(*this, stream, vertices_).run();
  forgetGone();
}

// The triangles that a node changes are taken to lie within two lengths of its edge.
double ObjectReplica::intervals(const MorphClock& clock, const proto::ObjectStream& stream, Slot slot) const {
  if (clock.isEven()) return clock.intervals({}, 0);
  const proto::MeshTopology& mesh = objects_->domain(object_).topology();
  const proto::ObjectModel& model = objects_->modelOf(object_);
  const auto place = [&](NodeId v) {
    const glm::ivec3& steps = mesh.isBase(v) ? model.base[proto::baseVertexOf(v)] : stepsOf(stream, mesh.slot(v));
    return glm::dvec3(steps) * model.step_m;
  };
  const auto [a, b] = mesh.endpoints(mesh.node(slot));
  return clock.intervals(place(mesh.node(slot)), 2 * glm::distance(place(a), place(b)));
}

// By the normals that the last mesh ends with at the ends of the node's edge, with 30 degrees to spare for the
// triangles about it. `from` in the scene's frame.
bool ObjectReplica::facesAway(const proto::View& from, Slot slot) const {
  constexpr double kSpare = 0.5;
  const proto::SurfaceDomain& domain = objects_->domain(object_);
  if (!domain.is_closed) return false;
  for (NodeId end : domain.topology().endpoints(domain.topology().node(slot))) {
    const auto at = vertices_.numbers.find(end);
    if (at == vertices_.numbers.end()) return false;
    const glm::dvec3 to_eye = from.pose.eye - vertices_.position[1][at->second];
    const double front = glm::dot(unpackNormal(vertices_.normal[1][at->second]), to_eye);
    if (front + from.region_radius_m > -kSpare * glm::length(to_eye)) return false;
  }
  return true;
}

const glm::ivec3& ObjectReplica::stepsOf(const proto::ObjectStream& stream, Slot slot) const {
  const auto gone = gone_.find(slot);
  return gone != gone_.end() ? gone->second : stream.position(object_, slot);
}

void ObjectReplica::forgetGone() {
  std::erase_if(gone_, [&](const auto& node) {
    return !proto::contains(from_, node.first) && !proto::contains(to_, node.first);
  });
}

void ObjectReplica::appendTo(KeyframeMesh& mesh) const {
  BlendMesh& out = mesh.objects;
  const auto first = static_cast<uint32_t>(out.from_positions.size());
  for (const Vertices::Corner& c : vertices_.corners) {
    out.from_positions.emplace_back(glm::vec3(vertices_.position[0][c.vertex] - mesh.origin), 0.0f);
    out.to_positions.emplace_back(glm::vec3(vertices_.position[1][c.vertex] - mesh.origin), 0.0f);
    out.from_normals.push_back(vertices_.normal[0][c.vertex]);
    out.to_normals.push_back(vertices_.normal[1][c.vertex]);
    out.places.push_back(c.place);
  }
  mesh.object_parts.push_back({static_cast<uint32_t>(out.indices.size()),
                               static_cast<uint32_t>(vertices_.indices.size()), objects_->placement(object_).model});
  for (uint32_t v : vertices_.indices) out.indices.push_back(first + v);
}

}  // namespace foreland::client
