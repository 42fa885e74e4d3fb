#include "terrain/pipeline/block_plan.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "base/check.h"
#include "terrain/pipeline/make_void_fill.h"
#include "terrain/pipeline/scene_parts.h"
#include "terrain/store/file/checksum.h"
#include "terrain/store/format.h"

namespace foreland::terrain {

namespace {

constexpr uint32_t kBlockVersion = 1;  // moves when blocks of the same heights would have other bytes
constexpr uint64_t kSamplesAtOnce = 1u << 20;

template <class T>
ByteSpan bytesOf(const T& value) {
  return {reinterpret_cast<const uint8_t*>(&value), sizeof(value)};
}

// What all blocks follow from, beside their heights.
uint64_t commonId(const BlockPlan& plan) {
  FileHeader header;
  header.version = kBlockVersion;
  header.roots_x = plan.shape.roots_x, header.roots_y = plan.shape.roots_y, header.root_log2 = plan.shape.root_log2;
  header.samples_x = plan.shape.samples_x, header.samples_y = plan.shape.samples_y;
  header.sparse_levels = plan.block_log2;
  putFrame(plan.frame, header);
  return xxh64(bytesOf(header));
}

// Which of the wider quanta all heights seen are multiples of, and what else is asked of them.
struct Seen {
  static constexpr std::array<double, 3> kQuanta{1.0, 0.5, 0.25};
  std::array<bool, 3> fits{true, true, true};
  float lowest = HUGE_VALF, highest = -HUGE_VALF;
  uint64_t voids = 0;
  bool says_something = false;

  // Of an epoch, whose voids are no lack.
  void addUnlessVoid(float h) {
    if (std::isnan(h)) return;
    says_something = true;
    if (std::isfinite(h)) return add(h);
    lowest = std::min(lowest, h), highest = std::max(highest, h);  // fits no quantum
  }
  void add(float h) {
    if (!std::isfinite(h)) {
      ++voids;
      return;
    }
    for (size_t i = 0; i < kQuanta.size(); ++i) fits[i] = fits[i] && std::remainder(double{h}, kQuanta[i]) == 0;
    lowest = std::min(lowest, h), highest = std::max(highest, h);
  }
};

Error doesNotFit(const std::string& title, float height_m, double quantum_m) {
  return {ErrorCode::kLimit, title + ": a height of " + std::to_string(height_m) + " m does not fit steps of " +
                                 std::to_string(quantum_m) +
                                 " m; use a larger --vertical-step or name the void value with --nodata"};
}

// `seen` of the ground and of each epoch.
void chooseQuantum(std::span<const Seen> seen, const PlanOptions& options, BlockPlan& plan) {
  if (!options.widen_quantum) return;
  for (size_t i = 0; i < Seen::kQuanta.size() && Seen::kQuanta[i] > options.height_quantum_m; ++i)
    if (std::ranges::all_of(seen, [&](const Seen& of) { return of.fits[i]; })) {
      plan.frame.height_quantum_m = Seen::kQuanta[i];
      plan.quantum_note = quantumNote(Seen::kQuanta[i]);
      return;
    }
}

// Of a date and what is said of a window then; `id` if that is nothing.
uint64_t epochId(const EpochSamples& epoch, const proto::LatticeWindow& window, uint64_t id) {
  const proto::LatticeWindow common = proto::LatticeWindow::common(epoch.window, window);
  if (common.isEmpty()) return id;
  bool says_something = false;
  uint64_t with_epoch = xxh64(bytesOf(epoch.time.us), id);
  std::vector<float> row(window.width);
  for (uint32_t y = window.y; y < window.y + window.height; ++y) {
    std::ranges::fill(row, kVoid);
    if (y >= common.y && y < common.y + common.height)
      for (uint32_t x = common.x; x < common.x + common.width; ++x)
        if (const float h = epoch.at(x, y); !std::isnan(h)) row[x - window.x] = h, says_something = true;
    with_epoch = xxh64({reinterpret_cast<const uint8_t*>(row.data()), row.size() * sizeof(float)}, with_epoch);
  }
  return says_something ? with_epoch : id;
}

// Of the heights alone.
uint64_t contentId(const ElevationInfo& info, const ErrorWindow& window, const HeightWindow& heights) {
  uint64_t id = 0;
  std::vector<float> row(widthOf(window));
  for (uint32_t y = window.low_y; y <= window.high_y; ++y) {
    for (uint32_t x = window.low_x; x <= window.high_x; ++x) row[x - window.low_x] = heights.at(info, x, y);
    id = xxh64({reinterpret_cast<const uint8_t*>(row.data()), row.size() * sizeof(float)}, id);
  }
  for (const EpochSamples& epoch : heights.epochs) id = epochId(epoch, samplesIn(window, info), id);
  return id;
}

uint64_t blockIdOf(uint64_t common, uint32_t column, uint32_t row, uint64_t content) {
  const std::array<uint64_t, 3> parts{column, row, content};
  return xxh64(bytesOf(parts), common);
}

}  // namespace

std::vector<BlockEpoch> datesOf(const std::vector<EpochRequest>& epochs) {
  std::vector<BlockEpoch> dates;
  for (const EpochRequest& epoch : epochs) dates.push_back({epoch.time, epoch.date});
  return dates;
}

uint64_t BlockPlan::id() const {
  uint64_t id = xxh64({reinterpret_cast<const uint8_t*>(ids.data()), ids.size() * sizeof(uint64_t)}, commonId(*this));
  for (const BlockEpoch& epoch : epochs) id = xxh64(bytesOf(epoch.time.us), id);
  return epochs.empty() ? id : xxh64(bytesOf(epoch_blend), id);
}

GroundInTime::GroundInTime(ElevationSource& source, const std::vector<EpochRequest>& epochs,
                           std::shared_ptr<const VoidFill> voids)
    : laid_(atFirstEpoch(source, epochs)), ground_(laid_), voids_(std::move(voids)), epochs_(epochs) {
  if (voids_) ground_ = std::make_shared<FilledSource>(*laid_, *voids_);
}

proto::LatticeWindow samplesIn(const ErrorWindow& window, const ElevationInfo& info) {
  const uint32_t last_x = std::min(window.high_x, info.width - 1), last_y = std::min(window.high_y, info.height - 1),
                 x = std::min(window.low_x, last_x), y = std::min(window.low_y, last_y);
  return {x, y, last_x - x + 1, last_y - y + 1};
}

Result<HeightWindow> readWindow(const GroundInTime& ground, const ErrorWindow& window) {
  const ElevationInfo& info = ground.info();
  const proto::LatticeWindow samples = samplesIn(window, info);
  HeightWindow part{samples.x, samples.y, samples.width, samples.height};
  part.metres.resize(size_t{part.width} * part.height);
  const auto step = static_cast<uint32_t>(std::max<uint64_t>(1, kSamplesAtOnce / info.width));
  std::vector<float> rows;
  for (uint32_t done = 0; done < part.height; done += step) {
    const uint32_t count = std::min(step, part.height - done);
    rows.resize(size_t{count} * info.width);
    if (Status s = ground.first().readRows(part.y + done, count, rows); !s.ok()) return s.error();
    for (uint32_t i = 0; i < count; ++i)
      std::copy_n(rows.begin() + static_cast<ptrdiff_t>(size_t{i} * info.width + part.x), part.width,
                  part.metres.begin() + static_cast<ptrdiff_t>(size_t{done + i} * part.width));
  }
  for (const EpochRequest& request : ground.epochs()) {
    auto epoch = readEpoch(request, info, part.epochs.empty() ? proto::LatticeWindow{} : samples);
    if (!epoch) return epoch.error();
    part.epochs.push_back(std::move(*epoch));
  }
  return part;
}

uint64_t blockId(const BlockPlan& plan, const ElevationInfo& info, const Blocks& blocks, uint32_t column, uint32_t row,
                 const HeightWindow& heights) {
  return blockIdOf(commonId(plan), column, row, contentId(info, blocks.withHalo(column, row), heights));
}

Status forEachBlocks(
    const GroundInTime& ground, const Blocks& blocks, uint64_t memory_bytes,
    const std::function<Status(uint32_t row, uint32_t first, uint32_t end, const HeightWindow& heights)>& visit) {
  const uint64_t side = (1ull << blocks.log2) + 2 * Blocks::kHalo;
  const uint64_t grounds = std::max<uint64_t>(ground.epochs().size(), 1);
  const auto at_once = static_cast<uint32_t>(
      std::clamp<uint64_t>(memory_bytes / 3 / (side * side * sizeof(float) * grounds), 1, blocks.columns()));
  for (uint32_t row = 0; row < blocks.rows(); ++row)
    for (uint32_t first = 0; first < blocks.columns(); first += at_once) {
      const uint32_t end = std::min(first + at_once, blocks.columns());
      const ErrorWindow west = blocks.withHalo(first, row), east = blocks.withHalo(end - 1, row);
      const auto heights = readWindow(ground, {west.low_x, west.low_y, east.high_x, east.high_y});
      if (!heights) return heights.error();
      if (Status s = visit(row, first, end, *heights); !s.ok()) return s;
    }
  return {};
}

Result<BlockPlan> emptyPlan(const ElevationSource& source, double height_quantum_m, uint32_t block_log2,
                            proto::EpochBlend blend) {
  const ElevationInfo& info = source.info();
  const auto grid = gridFor(info);
  if (!grid) return grid.error();
  if (source.sparse() != nullptr)
    return Error{
        ErrorCode::kUnsupported,
        info.title + ": a lattice that is fine in places only is not made block by block yet; build it at once"};
  if (!Blocks::canCut(*grid))
    return Error{ErrorCode::kUnsupported, info.title + ": " + std::to_string(info.width) + " x " +
                                              std::to_string(info.height) +
                                              " samples are too few to be cut; foreland build makes them at once"};
  if (blend == proto::EpochBlend::kCatmullRom)
    return Error{ErrorCode::kUnsupported,
                 info.title +
                     ": ground that overshoots its epochs (--epoch-blend catmull-rom) is not made block by block yet; "
                     "build it at once (foreland build with a larger --memory), or blend by b-spline"};
  BlockPlan plan{.shape = grid->shape(), .frame = info.frame, .block_log2 = block_log2, .epoch_blend = blend};
  plan.frame.height_quantum_m = height_quantum_m;
  return plan;
}

namespace {

// What a look at all samples finds, and whether it came to its end: it stops at a void of the ground.
struct Look {
  std::vector<Seen> seen;          // of the ground, then of each epoch
  std::vector<uint64_t> contents;  // by block
};

Result<Look> lookAt(const GroundInTime& ground, const Blocks& blocks, const PlanOptions& options, const Seen& seen,
                    const Progress& progress) {
  Look look{std::vector<Seen>(1 + ground.epochs().size()), std::vector<uint64_t>(blocks.count())};
  look.seen[0] = seen;
  progress.report("looking", 0);
  const Status read =
      forEachBlocks(ground, blocks, options.memory_bytes,
                    [&](uint32_t row, uint32_t first, uint32_t end, const HeightWindow& heights) -> Status {
                      for (const float h : heights.metres) look.seen[0].add(h);
                      if (look.seen[0].voids > 0) return stopped();
                      for (size_t i = 0; i < heights.epochs.size(); ++i)
                        for (const float h : heights.epochs[i].metres) look.seen[1 + i].addUnlessVoid(h);
                      for (uint32_t column = first; column < end; ++column)
                        look.contents[uint64_t{row} * blocks.columns() + column] =
                            contentId(ground.info(), blocks.withHalo(column, row), heights);
                      progress.report("looking", static_cast<double>(row + 1) / blocks.rows());
                      return progress.keepGoing() ? Status() : Status(stopped());
                    });
  if (!read.ok() && look.seen[0].voids == 0) return read.error();
  return look;
}

// Of a source with voids. The quantum is for its own heights, the range for all.
Result<Look> fillAndLook(ElevationSource& source, const Blocks& blocks, const PlanOptions& options,
                         const Progress& progress, BlockPlan& plan) {
  CHECK_TRUE(!options.voids.empty());
  Seen raw;
  const auto see = [&](std::span<const float> row) {
    for (const float h : row) raw.add(h);
  };
  const GroundInTime with_voids(source, options.epochs, nullptr);
  auto made = makeVoidFill(with_voids.first(), options.voids, see, progress);
  if (!made) return made.error();
  plan.voids = made->fill;
  plan.voids_filled = made->report.samples;
  plan.voids_note = made->report.note;
  auto look = lookAt({source, options.epochs, plan.voids}, blocks, options, {.fits = {}}, progress);
  if (!look) return look;
  if (look->seen[0].voids > 0) return changedWhileRead(source.info().title);
  look->seen[0].fits = raw.fits;
  return look;
}

// The range of what was seen, once its quantum is known.
Status setRange(std::span<const Seen> seen, const std::string& title, BlockPlan& plan) {
  const double quantum_m = plan.frame.height_quantum_m;
  plan.range = {proto::kMaxHeight, -proto::kMaxHeight};
  for (size_t i = 0; i < seen.size(); ++i)
    for (const float h : {seen[i].lowest, seen[i].highest}) {
      if (i > 0 && !seen[i].says_something) continue;
      const auto quanta = quantised(h, quantum_m);
      if (!quanta) return i == 0 ? doesNotFit(title, h, quantum_m) : heightDoesNotFit(plan.epochs[i - 1].date, h);
      plan.range = {std::min(plan.range.lowest, *quanta), std::max(plan.range.highest, *quanta)};
    }
  return {};
}

}  // namespace

Result<BlockPlan> planBlocks(ElevationSource& source, const PlanOptions& options, const Progress& progress) {
  const ElevationInfo& info = source.info();
  auto plan = emptyPlan(source, options.height_quantum_m, options.block_log2, options.epoch_blend);
  if (!plan) return plan;
  if (Status s = checkEpochs(options.epochs, info); !s.ok()) return s.error();
  if (options.epochs.empty() && options.epoch_blend != proto::EpochBlend::kLinear) return nothingToBlend();
  plan->epochs = datesOf(options.epochs);
  if (const auto dates = datesOf(plan->epochs, plan->epoch_blend, plan->shape); !dates) return dates.error();
  const auto grid = proto::GridTopology::create(plan->shape);
  const Blocks blocks{*grid, options.block_log2};
  auto look = lookAt({source, options.epochs, nullptr}, blocks, options, {}, progress);
  if (look && look->seen[0].voids > 0) look = fillAndLook(source, blocks, options, progress, *plan);
  if (!look) return look.error();
  chooseQuantum(look->seen, options, *plan);
  if (Status s = setRange(look->seen, info.title, *plan); !s.ok()) return s.error();
  const uint64_t common = commonId(*plan);
  for (uint32_t row = 0; row < blocks.rows(); ++row)
    for (uint32_t column = 0; column < blocks.columns(); ++column)
      plan->ids.push_back(blockIdOf(common, column, row, look->contents[plan->ids.size()]));
  return plan;
}

}  // namespace foreland::terrain
