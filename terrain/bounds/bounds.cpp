#include "terrain/bounds/bounds.h"

#include <atomic>
#include <optional>
#include <vector>

#include "terrain/bounds/error.h"
#include "terrain/bounds/fine_errors.h"
#include "terrain/bounds/node_row.h"
#include "terrain/bounds/spheres.h"
#include "terrain/parallel.h"

namespace foreland::terrain {

namespace {

// Errors of a row's nodes in metres, not saturated. Each worker has one for each level, with its scratch.
class PlanarRows {
 public:
  static PlanarError makeError(const BoundsJob& job, const proto::GeographicTables&) {
    return {job.grid, job.frame, job.heights};
  }
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
  static GeographicError makeError(const BoundsJob& job, const proto::GeographicTables& tables) {
    return {job.grid, job.frame, job.heights, tables};
  }
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
      : job_(job),
        levels_(job.spheres ? *job.spheres : proto::SphereLevels(job.grid, job.frame)),
        own_tables_(job.tables ? std::nullopt : std::optional(tablesOf(job))),
        tables_(job.tables ? *job.tables : *own_tables_),
        positions_(job.grid, job.frame, job.heights, tables_),
        extremes_(extremesOf(job, tables_)),
        error_(ErrorRows::makeError(job, tables_)) {}

  bool run() {
    double done = 0, all = 0;
    const int finest = std::min(job_.from_level, job_.grid.maxLevel());
    for (int number = finest; number >= 1; --number) all += cost(number);
    for (int number = finest; number >= 1; --number) {
      const NodeLevel level(job_.grid, number);
      const auto between = [&](uint64_t bands) {
        const double fraction = (done + cost(number) * static_cast<double>(bands) / level.bands()) / all;
        return !stopped_ && job_.onProgress(std::min(fraction, 1.0));
      };
      std::vector<std::optional<Scratch>> scratch(threadCount(job_.threads));
      const auto work = [&](uint64_t band, unsigned worker) {
        if (!scratch[worker]) scratch[worker].emplace(*this, level);
        if (!stopped_) fillBand(level, static_cast<uint32_t>(band), *scratch[worker]);
      };
      if (!parallelFor(level.bands(), job_.threads, work, between)) return false;
      done += cost(number);
    }
    return !stopped_;
  }

 private:
  // Relative cost of a level: a node costs about as much as scanning 32 samples, and each level scans all samples.
  double cost(int level) const {
    return 32.0 * (job_.grid.levelOffset(level + 1) - job_.grid.levelOffset(level)) +
           static_cast<double>(job_.heights.quanta.size());
  }

  // Of one worker, for one level.
  struct Scratch {
    Scratch(const BoundsPass& pass, const NodeLevel& level)
        : errors(pass.error_, pass.job_, level),
          spheres(pass.job_.grid, pass.levels_, pass.positions_, pass.extremes_, pass.job_.nodes, level.level) {}
    ErrorRows errors;
    SphereRows spheres;
    std::vector<NodeRecord> records;  // of the current band
    proto::Slot first = 0;            // slot of records[0]
    std::vector<double> errors_m, radii_m;
    std::vector<uint8_t> child_errors;
  };

  void fillBand(const NodeLevel& level, uint32_t number, Scratch& band) {
    const auto [first, count] = slots(level, number);
    band.first = first;
    band.records.assign(count, NodeRecord{});
    const uint32_t s = level.s, end = std::min((number + 1) * kTileCells, level.cellRows());
    for (uint32_t cell = number * kTileCells; cell < end; ++cell) {
      if (level.sides) fillRow(level.level, level.row(2 * s * cell), band);
      if (cell < level.cells_y) fillRow(level.level, level.row(2 * s * cell + s), band);
    }
    for (size_t page = 0; page < band.records.size(); page += proto::kPageSlots)
      widenSpheres(job_.grid, first + page, std::span(band.records).subspan(page, proto::kPageSlots));
    if (!job_.store(first, band.records)) stopped_ = true;
    if (level.level == job_.grid.maxLevel()) return;
    const NodeLevel finer(job_.grid, level.level + 1);
    for (uint32_t below = level.sides ? 2 * number : number; below <= (level.sides ? 2 * number + 1 : number); ++below)
      if (below < finer.bands()) {
        const auto [slot, idle] = slots(finer, below);
        job_.onIdle(job_.nodes.subspan(slot, idle));
      }
  }

  static proto::GeographicTables tablesOf(const BoundsJob& job) {
    return {proto::FrameTransform(job.frame), job.grid.maxX(), job.grid.maxY()};
  }
  static std::vector<RowPositions> extremesOf(const BoundsJob& job, const proto::GeographicTables& tables) {
    std::vector<RowPositions> extremes;
    for (const Heights& heights : {job.lowest, job.highest})
      if (!heights.quanta.empty()) extremes.emplace_back(job.grid, job.frame, heights, tables);
    return extremes;
  }

  bool isWanted(const NodeLevel& level, const NodeRow& row) const {
    return row.y + level.s >= job_.first_row && row.y <= uint64_t{job_.last_row} + level.s;
  }
  proto::QuantisedError minError(proto::Slot slot) const {
    return job_.min_errors.empty() ? proto::QuantisedError{} : job_.min_errors[slot];
  }

  void fillRow(int level, const NodeRow& row, Scratch& band) {
    if (!isWanted(NodeLevel(job_.grid, level), row)) return;
    band.errors_m.resize(row.count);
    band.radii_m.resize(row.count);
    band.child_errors.resize(row.count);
    if (job_.raw_errors.empty()) band.errors.compute(row, band.errors_m);
    band.spheres.compute(row, band.radii_m, band.child_errors);
    row.forEachRun(job_.grid, [&](uint32_t i, proto::Slot slot, uint32_t count) {
      NodeRecord* record = &band.records[slot - band.first];
      for (uint32_t end = i + count; i < end; ++i, record += row.slot_step) {
        const int32_t height = positions_.quanta(row.first_x + i * row.step_x, row.y);
        const proto::Slot at = band.first + static_cast<proto::Slot>(record - band.records.data());
        const proto::QuantisedError raw =
            job_.raw_errors.empty()
                ? std::max(proto::QuantisedError::roundUp(band.errors_m[i] + job_.rounding_m), minError(at))
                : job_.raw_errors[at];
        *record = NodeRecord::of(height, height - positions_.middleQuanta(row.node(i)),
                                 std::max(raw, proto::QuantisedError{band.child_errors[i]}),
                                 levels_.roundUp(level, band.radii_m[i] + kSpherePad_m));
      }
    });
  }

  struct Slots {
    proto::Slot first, count;
  };
  // The slots of a band; all bands of a level have the same number.
  Slots slots(const NodeLevel& level, uint32_t band) const {
    const proto::Slot begin = job_.grid.levelOffset(level.level),
                      each = (job_.grid.levelOffset(level.level + 1) - begin) / level.bands();
    return {begin + band * each, each};
  }

  const BoundsJob& job_;
  proto::SphereLevels levels_;
  std::optional<proto::GeographicTables> own_tables_;  // none if the job has some
  const proto::GeographicTables& tables_;
  RowPositions positions_;
  std::vector<RowPositions> extremes_;
  Error error_;
  std::atomic<bool> stopped_{false};
};

}  // namespace

bool computeBounds(const BoundsJob& job) {
  CHECK_EQ(job.nodes.size(), static_cast<size_t>(job.grid.slotCount()));
  if (job.frame.kind == proto::FrameKind::kPlanar) return BoundsPass<PlanarError, PlanarRows>(job).run();
  return BoundsPass<GeographicError, GeographicRows>(job).run();
}

}  // namespace foreland::terrain
