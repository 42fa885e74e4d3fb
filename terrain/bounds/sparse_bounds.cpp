#include "terrain/bounds/sparse_bounds.h"

#include <algorithm>
#include <cstdlib>
#include <glm/geometric.hpp>
#include <vector>

#include "proto/space/frame_grid.h"
#include "terrain/bounds/sparse_errors.h"
#include "terrain/bounds/spheres.h"
#include "terrain/parallel.h"

namespace foreland::terrain {

namespace {

using proto::NodeId;
using proto::NodeRecord;

// What errors, which are measured between heights and spheres, take of the time.
constexpr double kErrorShare = 0.6;

class Bounds {
 public:
  explicit Bounds(const SparseBoundsJob& job)
      : job_(job),
        grid_(job.grid),
        levels_(job.grid, job.frame),
        positions_(job.frame, grid_.maxX(), grid_.maxY()),
        records_(job.grid, job.pages, job.base, job.records) {}

  bool run() {
    double done = 0;
    for (int level = 1; level <= grid_.maxLevel(); ++level)
      if (!forEachNode(level, done, [&](NodeId n, uint64_t place) { setHeight(n, level, place); })) return false;
    errors_ = measureSparseErrors(grid_, positions_, records_, job_.threads, [&](double part) {
      return job_.onProgress(0.5 * (1 - kErrorShare) + kErrorShare * part);
    });
    if (errors_.size() < records_.size()) return false;
    done += kErrorShare;
    for (int level = grid_.maxLevel(); level >= 1; --level) {
      if (!forEachNode(level, done, [&](NodeId n, uint64_t place) { setBounds(n, level, place); })) return false;
      for (const SparseRecords::Page& page : records_.pagesOf(level))
        widenSpheres(grid_, page.first, job_.records.subspan(page.place, proto::kPageSlots));
    }
    return true;
  }

 private:
  // Calls visit(node, place of its record) for the nodes of a level, on several threads, and adds to what is done.
  template <class Visit>
  bool forEachNode(int level, double& done, const Visit& visit) const {
    const double share = 0.5 * (1 - kErrorShare) * static_cast<double>(records_.pagesOf(level).size()) /
                         static_cast<double>(job_.pages.pageCount()),
                 each = share / std::max(1.0, static_cast<double>(records_.pieceCount(level)));
    const bool is_complete = parallelFor(
        records_.pieceCount(level), job_.threads,
        [&](uint64_t piece, unsigned) { records_.forEachNode(level, piece, visit); },
        [&](uint64_t pieces) { return job_.onProgress(std::min(done + each * static_cast<double>(pieces), 1.0)); });
    done += share;
    return is_complete;
  }

  void setHeight(NodeId n, int level, uint64_t place) {
    const int32_t height = job_.height(n);
    CHECK_LT(std::abs(height), proto::kMaxHeight);
    const auto [a, b] = grid_.endpoints(n, level);
    records_[place] =
        NodeRecord::of(height, height - proto::middleOf(records_.heightOf(a), records_.heightOf(b)), {}, {});
  }

  void setBounds(NodeId n, int level, uint64_t place) {
    NodeRecord& record = records_[place];
    proto::QuantisedError error = errors_[place];
    double radius_m = 0;
    bool has_all = level < grid_.maxLevel();
    const glm::dvec3 middle = positions_.position(n, record.middle());
    const auto include = [&](const glm::dvec3& at, double more_m) {
      radius_m = std::max(radius_m, glm::distance(middle, at) + more_m);
    };
    for (const NodeId child : grid_.children(n, level)) {
      const uint64_t below_place = records_.placeOf(child, level + 1);
      if (below_place == SparseRecords::kNowhere) {
        has_all = false;
        continue;
      }
      const NodeRecord& below = records_[below_place];
      error = std::max(error, below.error());
      include(positions_.position(child, below.middle()), levels_.radius(level + 1, below.radius()));
    }
    // The corners of a support lie in those of all its children, too.
    if (!has_all) {
      include(positions_.position(n, record.height()), 0);
      for (const NodeId v : grid_.endpoints(n, level)) include(positions_.position(v, records_.heightOf(v)), 0);
      for (const NodeId v : grid_.apexes(n, level)) include(positions_.position(v, records_.heightOf(v)), 0);
    }
    record =
        NodeRecord::of(record.height(), record.displacement(), error, levels_.roundUp(level, radius_m + kSpherePad_m));
  }

  const SparseBoundsJob& job_;
  const proto::GridTopology& grid_;
  proto::SphereLevels levels_;
  proto::FrameGrid positions_;
  SparseRecords records_;
  std::vector<proto::QuantisedError> errors_;
};

}  // namespace

bool computeSparseBounds(const SparseBoundsJob& job) {
  CHECK_EQ(job.records.size(), job.pages.pageCount() * proto::kPageSlots);
  return Bounds(job).run();
}

}  // namespace foreland::terrain
