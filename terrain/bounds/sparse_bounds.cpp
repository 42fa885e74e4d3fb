#include "terrain/bounds/sparse_bounds.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/geometric.hpp>
#include <vector>

#include "proto/space/frame_grid.h"
#include "terrain/bounds/spheres.h"
#include "terrain/bounds/support.h"
#include "terrain/parallel.h"

namespace foreland::terrain {

namespace {

using proto::NodeId;
using proto::NodeRecord;
using proto::Slot;

constexpr uint32_t kPieces = 16;  // of a page: coarse levels have few pages, whose nodes have large supports
constexpr uint32_t kPieceSlots = proto::kPageSlots / kPieces;

struct StoredPage {
  Slot first;
  uint64_t place;
};

// The pages that are there, level by level.
std::vector<std::vector<StoredPage>> pagesByLevel(const proto::GridTopology& grid, const proto::PageDirectory& pages) {
  std::vector<std::vector<StoredPage>> levels(static_cast<size_t>(grid.maxLevel()) + 1);
  pages.forEachPage([&](Slot first, uint64_t place) {
    levels[static_cast<size_t>(grid.pagePlace(first).level)].push_back({first, place * proto::kPageSlots});
  });
  return levels;
}

// A position of the lattice, on the square of a column of roots that it may only border, and the height of the surface
// there.
struct Vertex {
  NodeId id;
  uint32_t root_x;
  int32_t quanta;
};

class Bounds {
 public:
  explicit Bounds(const SparseBoundsJob& job)
      : job_(job),
        grid_(job.grid),
        levels_(job.grid, job.frame),
        positions_(job.frame, grid_.maxX(), grid_.maxY()),
        pages_(pagesByLevel(job.grid, job.pages)) {}

  bool run() {
    double done = 0;
    const auto pieces = static_cast<double>(job_.records.size()) / static_cast<double>(kPieceSlots);
    const auto progress = [&](double part) { return job_.onProgress(std::min((done + part) / (2 * pieces), 1.0)); };
    for (int level = 1; level <= grid_.maxLevel(); ++level) {
      const auto place = [&](uint64_t piece, unsigned) { setHeights(level, piece); };
      if (!forEachPiece(level, place, progress)) return false;
      done += static_cast<double>(pieceCount(level));
    }
    for (int level = grid_.maxLevel(); level >= 1; --level) {
      const auto bound = [&](uint64_t piece, unsigned) { setBounds(level, piece); };
      if (!forEachPiece(level, bound, progress)) return false;
      for (const StoredPage& page : pages_[static_cast<size_t>(level)])
        widenSpheres(grid_, page.first, job_.records.subspan(page.place, proto::kPageSlots));
      done += static_cast<double>(pieceCount(level));
    }
    return true;
  }

 private:
  uint64_t pieceCount(int level) const { return pages_[static_cast<size_t>(level)].size() * kPieces; }
  template <class Work, class Progress>
  bool forEachPiece(int level, const Work& work, const Progress& progress) {
    return parallelFor(pieceCount(level), job_.threads, work,
                       [&](uint64_t done) { return progress(static_cast<double>(done)); });
  }
  // Calls visit(node, record) for the nodes of a piece of a page, without padding.
  template <class Visit>
  void forEachNode(int level, uint64_t piece, const Visit& visit) {
    const StoredPage& page = pages_[static_cast<size_t>(level)][piece / kPieces];
    const auto nodes = grid_.pageNodes(level, page.first);
    const auto begin = static_cast<uint32_t>(piece % kPieces * kPieceSlots);
    for (uint32_t low = begin; low < begin + kPieceSlots; ++low)
      if (const NodeId n = nodes.at(low); grid_.contains(n)) visit(n, job_.records[page.place + low]);
  }

  void setHeights(int level, uint64_t piece) {
    forEachNode(level, piece, [&](NodeId n, NodeRecord& record) {
      const int32_t height = job_.height(n);
      CHECK_LT(std::abs(height), proto::kMaxHeight);
      const auto [a, b] = grid_.endpoints(n, level);
      record = NodeRecord::of(height, height - proto::middleOf(heightOf(a), heightOf(b)), {}, {});
    });
  }
  void setBounds(int level, uint64_t piece) {
    forEachNode(level, piece, [&](NodeId n, NodeRecord& record) {
      proto::QuantisedError error = proto::QuantisedError::roundUp(errorOf(n, level));
      double radius_m = 0;
      bool has_all = level < grid_.maxLevel();
      const glm::dvec3 middle = positions_.position(n, record.middle());
      const auto include = [&](const glm::dvec3& at, double more_m) {
        radius_m = std::max(radius_m, glm::distance(middle, at) + more_m);
      };
      for (const NodeId child : grid_.children(n, level)) {
        const NodeRecord* below = find(child, level + 1);
        if (!below) {
          has_all = false;
          continue;
        }
        error = std::max(error, below->error());
        include(positions_.position(child, below->middle()), levels_.radius(level + 1, below->radius()));
      }
      // The corners of a support lie in those of all its children, too.
      if (!has_all) {
        include(positions_.position(n, record.height()), 0);
        for (const NodeId v : grid_.endpoints(n, level)) include(positions_.position(v, heightOf(v)), 0);
        for (const NodeId v : grid_.apexes(n, level)) include(positions_.position(v, heightOf(v)), 0);
      }
      record = NodeRecord::of(record.height(), record.displacement(), error,
                              levels_.roundUp(level, radius_m + kSpherePad_m));
    });
  }
  const NodeRecord* find(NodeId n, int level) const {
    const uint64_t place = job_.pages.placeOf(grid_.slot(n, level));
    return place == proto::PageDirectory::kNowhere ? nullptr : &job_.records[place];
  }
  // Of a base vertex, or of a node whose page is there.
  int32_t heightOf(NodeId v) const {
    const int level = grid_.level(v);
    return level == 0 ? job_.base.at(grid_, v) : find(v, level)->height();
  }

  // What planes and distances are made of: heights where the frame is planar, positions in space where it is not.
  struct Heights {
    using Value = double;
    static double at(const Bounds&, const Vertex& v) { return v.quanta; }
    static double distance(double a, double b) { return std::fabs(a - b); }
    // Rounded up, since the product itself may round down.
    static double metres(double quanta, const proto::Frame& frame) {
      return quanta * frame.height_quantum_m * (1 + 0x1p-51);
    }
  };
  struct Space {
    using Value = glm::dvec3;
    static glm::dvec3 at(const Bounds& bounds, const Vertex& v) {
      return bounds.positions_.position(bounds.grid_.nameIn(v.root_x, v.id), v.quanta);
    }
    static double distance(const glm::dvec3& a, const glm::dvec3& b) { return glm::distance(a, b); }
    // As GeographicError: what is less than rounding is nothing.
    static double metres(double distance_m, const proto::Frame&) { return distance_m > 2e-8 ? distance_m + 5e-8 : 0; }
  };

  // The triangles beside a node's edge, each on the square of the column of roots that holds it, by positions there.
  template <class Visit>
  void forEachTriangle(NodeId n, int level, const Visit& visit) const {
    if (!grid_.isCube()) {
      const auto ends = grid_.endpoints(n, level);
      for (const NodeId top : grid_.apexes(n, level)) visit(0, SupportTriangle(n, ends, top));
      return;
    }
    const int32_t s = 1 << grid_.scaleLog2(n);
    const proto::Cube cube = grid_.cube();
    for (const proto::CubePlace& at : cube.placesOf(n)) {
      const bool is_centre = (at.x & at.y & s) != 0, rises = ((at.x ^ at.y) & 2 * s) == 0;
      const int32_t dx = at.x & s, dy = is_centre ? (rises ? s : -s) : at.y & s;
      const auto vertex = [&](int32_t east, int32_t north) {
        return NodeId::at((at.face << grid_.shape().root_log2) + static_cast<uint32_t>(at.x + east),
                          static_cast<uint32_t>(at.y + north));
      };
      for (const int32_t side : {-1, 1})
        if (cube.isWithin({at.face, at.x - side * dy, at.y + side * dx}))
          visit(at.face,
                SupportTriangle(vertex(0, 0), {vertex(-dx, -dy), vertex(dx, dy)}, vertex(-side * dy, side * dx)));
    }
  }
  double errorOf(NodeId n, int level) const {
    return job_.frame.kind == proto::FrameKind::kPlanar ? errorIn<Heights>(n, level) : errorIn<Space>(n, level);
  }
  template <class In>
  double errorIn(NodeId n, int level) const {
    double worst = 0;
    forEachTriangle(n, level, [&](uint32_t root_x, const SupportTriangle& t) {
      const auto vertex = [&](NodeId at) { return Vertex{at, root_x, heightOf(grid_.nameIn(root_x, at))}; };
      const Vertex a = vertex(t.a), b = vertex(t.b), apex = vertex(t.apex);
      const auto plane = t.plane(In::at(*this, a), In::at(*this, b), In::at(*this, apex));
      const auto measure = [&](const Vertex& v) {
        const auto dx = static_cast<int32_t>(v.id.x() - t.node.x()), dy = static_cast<int32_t>(v.id.y() - t.node.y());
        worst = std::max(worst, In::distance(In::at(*this, v), plane.at(dx, dy)));
      };
      descend(a, b, apex, level, measure);
    });
    return In::metres(worst, job_.frame);
  }

  bool isData(NodeId v) const { return v.x() < grid_.shape().samples_x && v.y() < grid_.shape().samples_y; }
  // Measures all vertices that are there of a triangle that is halved between a and b, and in which there is data.
  template <class Measure>
  void descend(const Vertex& a, const Vertex& b, const Vertex& apex, int level, const Measure& measure) const {
    const NodeId middle = NodeId::at((a.id.x() + b.id.x()) / 2, (a.id.y() + b.id.y()) / 2);
    const NodeRecord* record = level <= grid_.maxLevel() ? find(grid_.nameIn(a.root_x, middle), level) : nullptr;
    if (!record) return measureBeyond({&a, &b, &apex}, measure);
    const Vertex m{middle, a.root_x, record->height()};
    if (isData(middle)) measure(m);
    descend(a, apex, m, level + 1, measure);
    descend(b, apex, m, level + 1, measure);
  }
  // Of a triangle that is not halved and that the data's border cuts, the corners beyond: the surface is even between.
  template <class Measure>
  void measureBeyond(const std::array<const Vertex*, 3>& corners, const Measure& measure) const {
    uint32_t low_x = corners[0]->id.x(), low_y = corners[0]->id.y();
    for (const Vertex* v : corners) low_x = std::min(low_x, v->id.x()), low_y = std::min(low_y, v->id.y());
    if (low_x + 1 >= grid_.shape().samples_x || low_y + 1 >= grid_.shape().samples_y) return;
    for (const Vertex* v : corners)
      if (!isData(v->id)) measure(*v);
  }

  const SparseBoundsJob& job_;
  const proto::GridTopology& grid_;
  proto::SphereLevels levels_;
  proto::FrameGrid positions_;
  std::vector<std::vector<StoredPage>> pages_;
};

}  // namespace

bool computeSparseBounds(const SparseBoundsJob& job) {
  CHECK_EQ(job.records.size(), job.pages.pageCount() * proto::kPageSlots);
  return Bounds(job).run();
}

}  // namespace foreland::terrain
