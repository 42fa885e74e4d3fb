#include "terrain/bounds/sparse_errors.h"

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>

#include "terrain/bounds/bisection_triangle.h"
#include "terrain/bounds/support.h"
#include "terrain/parallel.h"

namespace foreland::terrain {

namespace {

using proto::GridTopology;
using proto::NodeId;
using proto::QuantisedError;

constexpr int kBandLevels = 12;  // what one walk goes down: 2^12 triangles at most

// Errors by place, raised by several threads at once.
class RaisedErrors {
 public:
  explicit RaisedErrors(uint64_t count) : values_(count) {}

  void raise(uint64_t place, QuantisedError error) {
    const std::atomic_ref<uint8_t> all(values_[place].value);
    uint8_t known = all.load(std::memory_order_relaxed);
    while (known < error.value && !all.compare_exchange_weak(known, error.value, std::memory_order_relaxed)) {}
  }
  std::vector<QuantisedError> take() { return std::move(values_); }

 private:
  std::vector<QuantisedError> values_;
};

// What planes and distances are made of: heights where the frame is planar, positions in space where it is not.
struct InHeights {
  using Value = double;
  static constexpr size_t kParts = 1;
  static Value at(const proto::FrameGrid&, NodeId, int32_t quanta) { return quanta; }
  static double part(Value v, size_t) { return v; }
  // Rounded up, since the product itself may round down.
  static double metres(double quanta, const proto::Frame& frame) {
    return quanta * frame.height_quantum_m * (1 + 0x1p-51);
  }
};
struct InSpace {
  using Value = glm::dvec3;
  static constexpr size_t kParts = 3;
  static Value at(const proto::FrameGrid& positions, NodeId v, int32_t quanta) { return positions.position(v, quanta); }
  static double part(const Value& v, size_t i) { return v[static_cast<glm::length_t>(i)]; }
  // As GeographicError: what is less than rounding is nothing.
  static double metres(double distance_m, const proto::Frame&) { return distance_m > 2e-8 ? distance_m + 5e-8 : 0; }
};

// The planes over the triangles that hold one another, the coarsest first, and how far the places are from each that
// were compared with it: in arrays of numbers, so that the loop over them becomes vector instructions.
template <class In>
class PlaneStack {
 public:
  void push(const SupportTriangle& t, const Plane<typename In::Value>& plane) {
    x_[depth_] = t.node.x(), y_[depth_] = t.node.y();
    for (size_t i = 0; i < In::kParts; ++i) {
      middle_[i][depth_] = In::part(plane.middle, i);
      per_x_[i][depth_] = In::part(plane.per_x, i);
      per_y_[i][depth_] = In::part(plane.per_y, i);
    }
    squared_[depth_++] = 0;
  }
  // The largest distance from the last plane.
  double pop() { return std::sqrt(squared_[--depth_]); }

  void measure(NodeId at, const typename In::Value& value) {
    const double x = at.x(), y = at.y();
    for (size_t k = 0; k < depth_; ++k) {
      const double dx = x - x_[k], dy = y - y_[k];
      double squared = 0;
      for (size_t i = 0; i < In::kParts; ++i) {
        const double off = In::part(value, i) - (middle_[i][k] + dx * per_x_[i][k] + dy * per_y_[i][k]);
        squared += off * off;
      }
      squared_[k] = squared_[k] < squared ? squared : squared_[k];
    }
  }

 private:
  static constexpr size_t kMost = GridTopology::kMaxLevels;
  using Numbers = std::array<double, kMost>;

  size_t depth_ = 0;
  Numbers x_{}, y_{}, squared_{};
  std::array<Numbers, In::kParts> middle_{}, per_x_{}, per_y_{};
};

// Goes down from one triangle after another. One owner.
template <class In>
class Walk {
 public:
  Walk(const GridTopology& grid, const proto::FrameGrid& positions, const SparseRecords& records, RaisedErrors& errors)
      : grid_(grid), positions_(positions), records_(records), errors_(errors) {}

  // Of the triangle that a node of this level halves, with this apex, both on the square of a column of roots that they
  // may only border: compares all that is there in it, down to the level `end`, with it and all that hold it.
  void run(uint32_t root_x, const SupportTriangle& t, int level, int end) {
    root_x_ = root_x;
    const glm::ivec2 a(t.a.x(), t.a.y()), b(t.b.x(), t.b.y()), apex(t.apex.x(), t.apex.y());
    pushHolders(glm::dvec2(a + b + apex) / 3.0, level);
    walk(vertex(a), vertex(b), vertex(apex), level, end);
    while (!places_.empty()) pop();
  }

 private:
  struct Vertex {
    NodeId id;
    typename In::Value value;
  };
  Vertex vertex(NodeId id, int32_t quanta) const { return {id, In::at(positions_, grid_.nameIn(root_x_, id), quanta)}; }
  Vertex vertex(glm::ivec2 p) const {
    const NodeId id = NodeId::at(static_cast<uint32_t>(p.x), static_cast<uint32_t>(p.y));
    return vertex(id, records_.heightOf(grid_.nameIn(root_x_, id)));
  }

  // The triangles around a point, as many as are coarser than a level.
  void pushHolders(glm::dvec2 p, int level) {
    const auto side = static_cast<int>(grid_.rootSize());
    const glm::ivec2 low = glm::ivec2(p) / side * side;
    BisectionTriangle t = BisectionTriangle::coarsest(side, p - glm::dvec2(low));
    for (int coarser = 1; coarser < level; ++coarser) {
      const Vertex a = vertex(low + t.a), b = vertex(low + t.b), apex = vertex(low + t.apex);
      const glm::ivec2 middle = low + t.middle();
      const NodeId n = NodeId::at(static_cast<uint32_t>(middle.x), static_cast<uint32_t>(middle.y));
      push(n, a, b, apex, records_.placeOf(grid_.nameIn(root_x_, n), coarser));
      t = t.halfWith(p - glm::dvec2(low));
    }
  }

  void push(NodeId n, const Vertex& a, const Vertex& b, const Vertex& apex, uint64_t place) {
    const SupportTriangle t(n, {a.id, b.id}, apex.id);
    planes_.push(t, t.plane(a.value, b.value, apex.value));
    places_.push_back(place);
  }
  void pop() {
    const double metres = In::metres(planes_.pop(), positions_.transform().frame());
    errors_.raise(places_.back(), QuantisedError::roundUp(metres));
    places_.pop_back();
  }

  void walk(const Vertex& a, const Vertex& b, const Vertex& apex, int level, int end) {
    const NodeId middle = NodeId::at((a.id.x() + b.id.x()) / 2, (a.id.y() + b.id.y()) / 2);
    const uint64_t place =
        level <= grid_.maxLevel() ? records_.placeOf(grid_.nameIn(root_x_, middle), level) : SparseRecords::kNowhere;
    if (place == SparseRecords::kNowhere) return measureBeyond({&a, &b, &apex});
    if (level == end) return;
    push(middle, a, b, apex, place);
    const Vertex m = vertex(middle, records_[place].height());
    if (isData(middle)) planes_.measure(m.id, m.value);
    walk(a, apex, m, level + 1, end);
    walk(b, apex, m, level + 1, end);
    pop();
  }

  bool isData(NodeId v) const { return v.x() < grid_.shape().samples_x && v.y() < grid_.shape().samples_y; }
  // Of a triangle that is not halved and that the data's border cuts, the corners beyond: the surface is even between.
  void measureBeyond(const std::array<const Vertex*, 3>& corners) {
    uint32_t low_x = corners[0]->id.x(), low_y = corners[0]->id.y();
    for (const Vertex* v : corners) low_x = std::min(low_x, v->id.x()), low_y = std::min(low_y, v->id.y());
    if (low_x + 1 >= grid_.shape().samples_x || low_y + 1 >= grid_.shape().samples_y) return;
    for (const Vertex* v : corners)
      if (!isData(v->id)) planes_.measure(v->id, v->value);
  }

  const GridTopology& grid_;
  const proto::FrameGrid& positions_;
  const SparseRecords& records_;
  RaisedErrors& errors_;
  uint32_t root_x_ = 0;
  PlaneStack<In> planes_;
  std::vector<uint64_t> places_;  // of the nodes that halve their triangles
};

// The triangles beside a node's edge, each on the square of the column of roots that holds it, by positions there.
template <class Visit>
void forEachTriangle(const GridTopology& grid, NodeId n, int level, const Visit& visit) {
  if (!grid.isCube()) {
    const auto ends = grid.endpoints(n, level);
    for (const NodeId top : grid.apexes(n, level)) visit(0, SupportTriangle(n, ends, top));
    return;
  }
  const int32_t s = 1 << grid.scaleLog2(n);
  const proto::Cube cube = grid.cube();
  for (const proto::CubePlace& at : cube.placesOf(n)) {
    const bool is_centre = (at.x & at.y & s) != 0, rises = ((at.x ^ at.y) & 2 * s) == 0;
    const int32_t dx = at.x & s, dy = is_centre ? (rises ? s : -s) : at.y & s;
    const auto vertex = [&](int32_t east, int32_t north) {
      return NodeId::at((at.face << grid.shape().root_log2) + static_cast<uint32_t>(at.x + east),
                        static_cast<uint32_t>(at.y + north));
    };
    for (const int32_t side : {-1, 1})
      if (cube.isWithin({at.face, at.x - side * dy, at.y + side * dx}))
        visit(at.face,
              SupportTriangle(vertex(0, 0), {vertex(-dx, -dy), vertex(dx, dy)}, vertex(-side * dy, side * dx)));
  }
}

template <class In>
std::vector<QuantisedError> measure(const GridTopology& grid, const proto::FrameGrid& positions,
                                    const SparseRecords& records, unsigned threads,
                                    const std::function<bool(double)>& onProgress) {
  RaisedErrors errors(records.size());
  std::vector<Walk<In>> walks(threadCount(threads), Walk<In>(grid, positions, records, errors));
  // Bands of levels, of which the last ends with the finest level and the first may have fewer.
  std::vector<int> begins{1};
  for (int level = grid.maxLevel() % kBandLevels + 1; level <= grid.maxLevel(); level += kBandLevels)
    if (level > 1) begins.push_back(level);
  uint64_t pieces = 0, done = 0;
  for (const int begin : begins) pieces += records.pieceCount(begin);
  for (size_t band = 0; band < begins.size(); ++band) {
    const int begin = begins[band], end = band + 1 < begins.size() ? begins[band + 1] : grid.maxLevel() + 1;
    const auto walkPiece = [&](uint64_t piece, unsigned worker) {
      records.forEachNode(begin, piece, [&](NodeId n, uint64_t) {
        forEachTriangle(grid, n, begin,
                        [&](uint32_t root_x, const SupportTriangle& t) { walks[worker].run(root_x, t, begin, end); });
      });
    };
    const auto progress = [&](uint64_t part) {
      return onProgress(static_cast<double>(done + part) / static_cast<double>(pieces));
    };
    if (!parallelFor(records.pieceCount(begin), threads, walkPiece, progress)) return {};
    done += records.pieceCount(begin);
  }
  return errors.take();
}

}  // namespace

std::vector<QuantisedError> measureSparseErrors(const GridTopology& grid, const proto::FrameGrid& positions,
                                                const SparseRecords& records, unsigned threads,
                                                const std::function<bool(double)>& onProgress) {
  return positions.transform().frame().kind == proto::FrameKind::kPlanar
             ? measure<InHeights>(grid, positions, records, threads, onProgress)
             : measure<InSpace>(grid, positions, records, threads, onProgress);
}

}  // namespace foreland::terrain
