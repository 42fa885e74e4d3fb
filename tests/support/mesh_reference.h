// Explicit subdivision: every triangle of every level, its corners as weights in the base face. The reference for what
// proto/topology/mesh_topology.h computes by arithmetic. For small meshes.
#pragma once

#include <algorithm>
#include <array>
#include <compare>
#include <cstdint>
#include <map>
#include <set>
#include <vector>

#include "proto/topology/mesh_topology.h"

namespace foreland::test {

// A point of the base complex, the same in each face that holds it: weights by base vertex, and the face if the point
// is inside one.
struct Key {
  uint32_t face = ~0u;
  std::map<uint32_t, uint32_t> weights;
  auto operator<=>(const Key&) const = default;
};

inline Key keyOf(const proto::MeshTopology& mesh, const proto::FacePoint& place) {
  Key key;
  for (uint32_t i = 0; i < 3; ++i)
    if (place.weights[i] > 0) key.weights[mesh.base().faces()[place.face][i]] = place.weights[i];
  if (key.weights.size() == 3) key.face = place.face;
  return key;
}
inline Key keyOf(const proto::MeshTopology& mesh, proto::NodeId v) { return keyOf(mesh, mesh.facePoint(v)); }

class MeshReference {
 public:
  using Weights = std::array<uint32_t, 3>;
  // By bisection, corners 0 and 1 are the refinement edge's.
  struct Triangle {
    uint32_t face;
    std::array<Weights, 3> corners;
  };
  struct Node {
    int level = 0;
    std::set<Key> endpoints;
    std::set<size_t> support;  // finest triangles
    std::set<Key> parents;
  };

  explicit MeshReference(const proto::MeshTopology& mesh)
      : mesh_(mesh), is_quad_(mesh.rule() == proto::MeshRule::kQuadrisection) {
    levels_.push_back(roots());
    for (int l = 1; l <= mesh.maxLevel(); ++l) levels_.push_back(refined(levels_.back()));
    for (int l = 1; l <= mesh.maxLevel(); ++l) addNodes(l);
    for (auto& [key, node] : nodes_) findParents(node);
  }

  const std::map<Key, Node>& nodes() const { return nodes_; }
  const std::vector<Triangle>& triangles(int level) const { return levels_[static_cast<size_t>(level)]; }
  Key key(const Triangle& t, int corner) const {
    const Weights& w = t.corners[static_cast<size_t>(corner)];
    return keyOf(mesh_, proto::FacePoint{t.face, {w[0], w[1], w[2]}});
  }

 private:
  static Weights middle(const Weights& a, const Weights& b) {
    return {(a[0] + b[0]) / 2, (a[1] + b[1]) / 2, (a[2] + b[2]) / 2};
  }
  std::vector<Triangle> roots() const {
    std::vector<Triangle> out;
    const uint32_t s = mesh_.weightScale();
    const std::array<Weights, 3> corner{{{s, 0, 0}, {0, s, 0}, {0, 0, s}}};
    for (uint32_t f = 0; f < mesh_.base().faceCount(); ++f) {
      if (is_quad_) out.push_back({f, corner});
      for (uint32_t i = 0; i < 3 && !is_quad_; ++i)
        out.push_back({f, {corner[i], corner[(i + 1) % 3], {s / 3, s / 3, s / 3}}});
    }
    return out;
  }
  std::vector<Triangle> refined(const std::vector<Triangle>& coarse) const {
    std::vector<Triangle> out;
    for (const auto& [f, c] : coarse) {
      const Weights ab = middle(c[0], c[1]), bc = middle(c[1], c[2]), ca = middle(c[2], c[0]);
      if (is_quad_)
        out.insert(out.end(), {{f, {c[0], ab, ca}}, {f, {ab, c[1], bc}}, {f, {ca, bc, c[2]}}, {f, {ab, bc, ca}}});
      else
        out.insert(out.end(), {{f, {c[2], c[0], ab}}, {f, {c[1], c[2], ab}}});
    }
    return out;
  }
  // The node's hat is 1 at the node and 0 at all other vertices of its level: quadrisection's support is a ring of that
  // level; bisection's the triangles that the node halves.
  void addNodes(int level) {
    const auto& coarse = triangles(level - 1);
    for (size_t t = 0; t < coarse.size(); ++t)
      for (int i = 0; i < (is_quad_ ? 3 : 1); ++i) {
        const int next = (i + 1) % 3;
        const Weights m =
            middle(coarse[t].corners[static_cast<size_t>(i)], coarse[t].corners[static_cast<size_t>(next)]);
        Node& node = nodes_[keyOf(mesh_, proto::FacePoint{coarse[t].face, {m[0], m[1], m[2]}})];
        node.level = level;
        node.endpoints = {key(coarse[t], i), key(coarse[t], next)};
        if (!is_quad_) addFinest(node, t, level - 1);
      }
    for (size_t t = 0; is_quad_ && t < triangles(level).size(); ++t)
      for (int i = 0; i < 3; ++i) {
        const auto found = nodes_.find(key(triangles(level)[t], i));
        if (found != nodes_.end() && found->second.level == level) addFinest(found->second, t, level);
      }
  }
  void addFinest(Node& node, size_t triangle, int level) const {
    const size_t share = levels_.back().size() / triangles(level).size();
    for (size_t i = 0; i < share; ++i) node.support.insert(triangle * share + i);
  }
  // S 3.4: parents' supports hold the child's; a node off its edge, whose support does so only because the surface ends
  // there, is none. Bisection's supports hold half of the child's each.
  void findParents(Node& child) const {
    for (const auto& [key, node] : nodes_) {
      if (node.level != child.level - 1) continue;
      const auto in_node = [&, &support = node.support](size_t t) { return support.contains(t); };
      const bool all = std::all_of(child.support.begin(), child.support.end(), in_node);
      const bool some = std::any_of(child.support.begin(), child.support.end(), in_node);
      if (is_quad_ ? all && child.endpoints.contains(key) : some) child.parents.insert(key);
    }
  }

  const proto::MeshTopology& mesh_;
  bool is_quad_;
  std::vector<std::vector<Triangle>> levels_;
  std::map<Key, Node> nodes_;
};

}  // namespace foreland::test
