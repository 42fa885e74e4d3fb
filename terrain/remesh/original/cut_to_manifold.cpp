#include "terrain/remesh/original/cut_to_manifold.h"

#include <algorithm>
#include <numeric>
#include <tuple>
#include <utility>

namespace foreland::terrain {

namespace {

// Disjoint sets of elements, each with a parity relative to its set.
class Sets {
 public:
  explicit Sets(size_t count) : parent_(count), is_odd_(count) { std::iota(parent_.begin(), parent_.end(), 0); }

  struct Root {
    uint32_t at;
    bool is_odd;
  };
  Root find(uint32_t element) {
    Root root{element, false};
    while (parent_[root.at] != root.at) root = {parent_[root.at], root.is_odd != is_odd_[root.at]};
    for (Root path{element, root.is_odd}; parent_[path.at] != path.at;) {
      const Root next{parent_[path.at], path.is_odd != is_odd_[path.at]};
      parent_[path.at] = root.at, is_odd_[path.at] = path.is_odd;
      path = next;
    }
    return root;
  }
  // Joins two elements whose parities are to differ or not. False if they are joined the other way.
  bool join(uint32_t a, uint32_t b, bool differ) {
    const Root of_a = find(a), of_b = find(b);
    const bool is_odd = (of_a.is_odd != of_b.is_odd) != differ;
    if (of_a.at == of_b.at) return !is_odd;
    const uint32_t child = std::max(of_a.at, of_b.at);
    parent_[child] = std::min(of_a.at, of_b.at), is_odd_[child] = is_odd;
    return true;
  }

 private:
  std::vector<uint32_t> parent_;
  std::vector<bool> is_odd_;
};

// A side of a face, and the edge that it is, under whichever naming of the corners.
struct Side {
  uint32_t low, high, at;  // at: 3 * face + edge
  bool operator<(const Side& other) const {
    return std::tie(low, high, at) < std::tie(other.low, other.high, other.at);
  }
  bool isEdgeOf(const Side& other) const { return low == other.low && high == other.high; }
};

template <class Name>
Side sideOf(uint32_t at, const Name& name) {
  const uint32_t begin = name(at), end = name(at - at % 3 + (at + 1) % 3);
  return {std::min(begin, end), std::max(begin, end), at};
}

// Calls `visit(begin, end)` for the sides of each edge. The sides must be sorted.
template <class Visit>
void forEdges(const std::vector<Side>& sides, const Visit& visit) {
  for (auto begin = sides.begin(); begin != sides.end();) {
    auto end = begin;
    while (end != sides.end() && end->isEdgeOf(*begin)) ++end;
    visit(begin, end);
    begin = end;
  }
}

class Cutter {
 public:
  Cutter(const std::vector<Triangle>& faces, const std::vector<Triangle>& sources)
      : faces_(faces), sources_(sources), is_cut_(3 * faces.size()) {}

  ManifoldTwins run() {
    pairSides();
    do connectPairs();
    while (has_cut_ && separateVertices());
    made_.cut_edges += contradictions_;
    return std::move(made_);
  }

 private:
  using Pair = std::pair<uint32_t, uint32_t>;  // sides

  uint32_t nameOf(const std::vector<Triangle>& names, uint32_t corner) const { return names[corner / 3][corner % 3]; }
  Side sideIn(const std::vector<Triangle>& names, uint32_t at) const {
    return sideOf(at, [&](uint32_t corner) { return nameOf(names, corner); });
  }
  uint32_t& twin(uint32_t side) { return made_.twins[side / 3][side % 3]; }

  // Which sides could be neighbours: two alone at their edge, or two that share an edge of the model's own.
  void pairSides() {
    std::vector<Side> sides, at_edge;
    for (uint32_t at = 0; at < 3 * faces_.size(); ++at) sides.push_back(sideIn(faces_, at));
    std::sort(sides.begin(), sides.end());
    forEdges(sides, [&](auto begin, auto end) {
      at_edge.clear();
      for (auto side = begin; side != end; ++side) at_edge.push_back(sideIn(sources_, side->at));
      if (at_edge.size() == 2)
        (at_edge[0].isEdgeOf(at_edge[1]) ? of_model_ : of_welding_).emplace_back(at_edge[0].at, at_edge[1].at);
      else if (at_edge.size() > 2)
        pairCrowded(at_edge);
    });
  }
  void pairCrowded(std::vector<Side>& at_edge) {
    has_cut_ = true;
    std::sort(at_edge.begin(), at_edge.end());
    bool is_of_model = false;
    forEdges(at_edge, [&](auto begin, auto end) {
      if (end - begin == 2) of_model_.emplace_back(begin->at, std::next(begin)->at);
      is_of_model |= end - begin > 2;
    });
    made_.cut_edges += is_of_model;
  }

  // Makes the sides of each pair that is not cut neighbours, unless their faces are neighbours by other ways that turn
  // one of them over. What depends on that is decided anew after each cut.
  void connectPairs() {
    made_.twins.assign(faces_.size(), {kNoIndex, kNoIndex, kNoIndex});
    contradictions_ = 0;
    Sets orientations(faces_.size());
    const auto connect = [&](const Pair& pair) {
      const uint32_t a = pair.first, b = pair.second;
      if (is_cut_[a]) return true;
      const bool is_same_way = nameOf(faces_, a) == nameOf(faces_, b);
      if (!orientations.join(a / 3, b / 3, is_same_way)) return has_cut_ = true, false;
      twin(a) = b, twin(b) = a;
      return true;
    };
    for (const Pair& pair : of_model_) contradictions_ += !connect(pair);
    for (const Pair& pair : of_welding_) connect(pair);
  }

  // Gives each fan a vertex of its own. Where an edge between two of these still has more than two faces, it is cut;
  // where it has two, they are neighbours. Returns whether something was cut, so that fans have changed.
  bool separateVertices() {
    Sets fans(3 * faces_.size());
    for (uint32_t a = 0; a < 3 * faces_.size(); ++a)
      if (const uint32_t b = twin(a); b != kNoIndex && a < b) joinCorners(fans, a, b);
    std::vector<Side> sides;
    for (uint32_t at = 0; at < 3 * faces_.size(); ++at)
      sides.push_back(sideOf(at, [&](uint32_t corner) { return fans.find(corner).at; }));
    std::sort(sides.begin(), sides.end());
    bool has_cut = false;
    forEdges(sides, [&](auto begin, auto end) { has_cut |= end - begin > 2 && cutAll(begin, end); });
    if (has_cut) return true;
    forEdges(sides, [&](auto begin, auto end) {
      if (end - begin == 2) twin(begin->at) = std::next(begin)->at, twin(std::next(begin)->at) = begin->at;
    });
    return false;
  }
  void joinCorners(Sets& fans, uint32_t a, uint32_t b) const {
    const uint32_t a_end = a - a % 3 + (a + 1) % 3, b_end = b - b % 3 + (b + 1) % 3;
    const bool is_same_way = nameOf(faces_, a) == nameOf(faces_, b);
    fans.join(a, is_same_way ? b : b_end, false);
    fans.join(a_end, is_same_way ? b_end : b, false);
  }
  template <class At>
  bool cutAll(At begin, At end) {
    bool has_cut = false;
    for (auto side = begin; side != end; ++side)
      if (twin(side->at) != kNoIndex) is_cut_[side->at] = has_cut = true;
    made_.cut_edges += has_cut;
    return has_cut;
  }

  const std::vector<Triangle>&faces_, &sources_;
  std::vector<Pair> of_model_, of_welding_;
  std::vector<bool> is_cut_;     // of sides
  bool has_cut_ = false;         // whether vertices may have several fans
  uint64_t contradictions_ = 0;  // edges of the model
  ManifoldTwins made_;
};

}  // namespace

ManifoldTwins cutToManifold(const std::vector<Triangle>& faces, const std::vector<Triangle>& sources) {
  return Cutter(faces, sources).run();
}

}  // namespace foreland::terrain
