#include "terrain/bounds/bounds.h"

#include <cmath>
#include <glm/geometric.hpp>

#include "terrain/bounds/error.h"
#include "terrain/parallel.h"

namespace foreland::terrain {

namespace {

using proto::NodeId;

constexpr double kPad_m = 1e-5;
constexpr uint32_t kBandCells = 16;  // a row of tiles of proto/grid.h

// The nodes of one level: cells of 2^(t+1) samples, one centre or two sides each.
struct Level {
  int level;
  bool sides;
  uint32_t scale_log2, cells_x, cells_y;

  Level(const proto::GridTopology& grid, int number)
      : level(number), sides(number & 1), scale_log2(grid.shape().root_log2 - 1 - static_cast<uint32_t>(number / 2)),
        cells_x((grid.maxX() >> (scale_log2 + 1)) + (sides ? 1 : 0)), cells_y((grid.maxY() >> (scale_log2 + 1)) + (sides ? 1 : 0)) {}
  uint32_t bands() const { return (cells_y + kBandCells - 1) / kBandCells; }
};

template <class ErrorOf>
class BoundsPass {
 public:
  explicit BoundsPass(const BoundsJob& job)
      : job_(job), positions_(job.frame, job.grid.maxX(), job.grid.maxY()), error_of_(job.grid, job.frame, job.heights) {}

  bool run() {
    const int levels = job_.grid.maxLevel();
    for (int level = levels; level >= 1; --level) {
      const Level shape(job_.grid, level);
      const auto between = [&](uint64_t bands) {
        return job_.onProgress((levels - level + static_cast<double>(bands) / shape.bands()) / levels);
      };
      if (!parallelFor(shape.bands(), job_.threads, [&](uint64_t band) { fillBand(shape, static_cast<uint32_t>(band)); }, between))
        return false;
    }
    return true;
  }

 private:
  void fillBand(const Level& level, uint32_t band) {
    const uint32_t t = level.scale_log2, s = 1u << t, end = std::min((band + 1) * kBandCells, level.cells_y);
    for (uint32_t cy = band * kBandCells; cy < end; ++cy)
      for (uint32_t cx = 0; cx < level.cells_x; ++cx) {
        const uint32_t x = cx << (t + 1), y = cy << (t + 1);
        if (!level.sides) {
          fill(NodeId::at(x + s, y + s));
        } else {
          if (x + s <= job_.grid.maxX()) fill(NodeId::at(x + s, y));
          if (y + s <= job_.grid.maxY()) fill(NodeId::at(x, y + s));
        }
      }
    releaseBand(level.level, level.bands(), band);
    if (level.level == job_.grid.maxLevel()) return;
    const Level finer(job_.grid, level.level + 1);
    for (uint32_t child : {2 * band, 2 * band + 1})
      if (level.sides && child < finer.bands()) releaseBand(finer.level, finer.bands(), child);
    if (!level.sides) releaseBand(finer.level, finer.bands(), band);
  }

  void fill(NodeId n) {
    NodeRecord record;
    record.height = job_.heights.clamped(n.x(), n.y());
    record.error = CompactBound::roundUp(error_of_.metres(n));
    const glm::dvec3 centre = positions_.position(n, record.height);
    const auto children = job_.grid.children(n);
    double radius_m = 0;
    for (NodeId child : children) {
      const NodeRecord& below = job_.nodes[job_.grid.slot(child)];
      record.error = std::max(record.error, below.error);
      radius_m = std::max(radius_m, glm::distance(centre, positions_.position(child, below.height)) + below.radius.metres());
    }
    if (children.count == 0) radius_m = reach(n, centre);
    record.radius = CompactBound::roundUp(radius_m + kPad_m);
    job_.nodes[job_.grid.slot(n)] = record;
  }

  // Of a finest node, whose support's only samples are itself and its corners.
  double reach(NodeId n, const glm::dvec3& centre) const {
    double radius_m = 0;
    const auto include = [&](NodeId v) {
      radius_m = std::max(radius_m, glm::distance(centre, positions_.position(v, job_.heights.clamped(v.x(), v.y()))));
    };
    for (NodeId v : job_.grid.endpoints(n)) include(v);
    for (NodeId v : job_.grid.apexes(n)) include(v);
    return radius_m;
  }

  void releaseBand(int level, uint32_t bands, uint32_t band) const {
    const uint64_t begin = job_.grid.levelOffset(level), count = job_.grid.levelOffset(level + 1) - begin;
    const uint64_t from = count * band / bands, to = count * (band + 1) / bands;  // bands are equal in slots
    job_.onIdle(job_.nodes.subspan(begin + from, to - from));
  }

  const BoundsJob& job_;
  proto::FrameGrid positions_;
  ErrorOf error_of_;
};

}  // namespace

bool computeBounds(const BoundsJob& job) {
  CHECK_EQ(job.nodes.size(), static_cast<size_t>(job.grid.slotCount()));
  if (job.frame.kind == proto::FrameKind::kPlanar) return BoundsPass<PlanarError>(job).run();
  return BoundsPass<GeographicError>(job).run();
}

}  // namespace foreland::terrain
