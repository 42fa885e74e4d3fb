#include "terrain/bounds/bounds.h"

#include "terrain/bounds/error.h"
#include "terrain/bounds/fine_errors.h"
#include "terrain/bounds/node_row.h"
#include "terrain/bounds/spheres.h"
#include "terrain/parallel.h"

namespace foreland::terrain {

namespace {

constexpr double kPad_m = 1e-5;

// Errors of a row's nodes, unsaturated, in metres. One for each band, which may keep scratch.
class PlanarRows {
 public:
  PlanarRows(const PlanarError& error, const BoundsJob& job, const NodeLevel& level)
      : error_(error), fine_(job.grid, job.heights, level), is_fine_(level.s <= FineErrors::kLargestReach) {}
  void compute(const NodeRow& row, std::span<double> errors_m) {
    FineErrors::Range done;
    if (is_fine_) done = fine_.compute(row, errors_m);
    for (uint32_t i = 0; i < row.count; ++i)
      errors_m[i] = i >= done.first && i < done.last ? error_.inMetres(errors_m[i]) : error_.metres(row.node(i));
  }

 private:
  const PlanarError& error_;
  FineErrors fine_;
  bool is_fine_;
};

class GeographicRows {
 public:
  GeographicRows(const GeographicError& error, const BoundsJob&, const NodeLevel&) : error_(error) {}
  void compute(const NodeRow& row, std::span<double> errors_m) const {
    for (uint32_t i = 0; i < row.count; ++i) errors_m[i] = error_.metres(row.node(i));
  }

 private:
  const GeographicError& error_;
};

template <class Error, class ErrorRows>
class BoundsPass {
 public:
  explicit BoundsPass(const BoundsJob& job)
      : job_(job), positions_(job.grid, job.frame, job.heights), error_(job.grid, job.frame, job.heights) {}

  bool run() {
    const int levels = job_.grid.maxLevel();
    for (int number = levels; number >= 1; --number) {
      const NodeLevel level(job_.grid, number);
      const auto between = [&](uint64_t bands) {
        return job_.onProgress((levels - number + static_cast<double>(bands) / level.bands()) / levels);
      };
      if (!parallelFor(level.bands(), job_.threads, [&](uint64_t band) { fillBand(level, static_cast<uint32_t>(band)); }, between))
        return false;
    }
    return true;
  }

 private:
  struct Band {
    ErrorRows errors;
    SphereRows spheres;
    std::vector<double> errors_m, radii_m;
    std::vector<uint16_t> child_errors;
  };

  void fillBand(const NodeLevel& level, uint32_t number) {
    Band band{ErrorRows(error_, job_, level), SphereRows(job_.grid, positions_, job_.nodes, level.level), {}, {}, {}};
    const uint32_t s = level.s, end = std::min((number + 1) * kTileCells, level.cellRows());
    for (uint32_t cell = number * kTileCells; cell < end; ++cell) {
      if (level.sides) fillRow(level.row(2 * s * cell), band);
      if (cell < level.cells_y) fillRow(level.row(2 * s * cell + s), band);
    }
    releaseBand(level, number);
    if (level.level == job_.grid.maxLevel()) return;
    const NodeLevel finer(job_.grid, level.level + 1);
    for (uint32_t below = level.sides ? 2 * number : number; below <= (level.sides ? 2 * number + 1 : number); ++below)
      if (below < finer.bands()) releaseBand(finer, below);
  }

  void fillRow(const NodeRow& row, Band& band) {
    band.errors_m.resize(row.count);
    band.radii_m.resize(row.count);
    band.child_errors.resize(row.count);
    band.errors.compute(row, band.errors_m);
    band.spheres.compute(row, band.radii_m, band.child_errors);
    row.forEachRun(job_.grid, [&](uint32_t i, proto::Slot slot, uint32_t count) {
      NodeRecord* record = &job_.nodes[slot];
      for (uint32_t end = i + count; i < end; ++i, record += row.slot_step) {
        record->height = positions_.steps(row.first_x + i * row.step_x, row.y);
        record->error = std::max(CompactBound::roundUp(band.errors_m[i]), CompactBound{band.child_errors[i]});
        record->radius = CompactBound::roundUp(band.radii_m[i] + kPad_m);
      }
    });
  }

  void releaseBand(const NodeLevel& level, uint32_t band) const {
    const uint64_t begin = job_.grid.levelOffset(level.level), count = job_.grid.levelOffset(level.level + 1) - begin;
    const uint64_t from = count * band / level.bands(), to = count * (band + 1) / level.bands();  // bands are equal in slots
    job_.onIdle(job_.nodes.subspan(begin + from, to - from));
  }

  const BoundsJob& job_;
  RowPositions positions_;
  Error error_;
};

}  // namespace

bool computeBounds(const BoundsJob& job) {
  CHECK_EQ(job.nodes.size(), static_cast<size_t>(job.grid.slotCount()));
  if (job.frame.kind == proto::FrameKind::kPlanar) return BoundsPass<PlanarError, PlanarRows>(job).run();
  return BoundsPass<GeographicError, GeographicRows>(job).run();
}

}  // namespace foreland::terrain
