#include "terrain/pipeline/build.h"

#include <algorithm>
#include <cmath>
#include <memory>
#include <new>
#include <optional>

#include "terrain/bounds/bounds.h"
#include "terrain/dem/voids/voids.h"
#include "terrain/imagery/relief.h"
#include "terrain/parallel.h"
#include "terrain/pipeline/scene_parts.h"
#include "terrain/pipeline/sparse_source.h"
#include "terrain/store/scene_writer.h"

namespace foreland::terrain {

namespace {

constexpr uint64_t kWindowSamples = 1u << 22;

// The heights of all samples, first in metres and then in quanta, in the same four bytes each: a raster of 16385 x
// 16385 fits in memory once.
class HeightRaster {
 public:
  explicit HeightRaster(size_t count) : count_(count), bytes_(new (std::nothrow) std::byte[count * sizeof(float)]) {
    if (bytes_) metres_ = new (bytes_.get()) float[count];
  }
  bool allocated() const { return bytes_ != nullptr; }
  std::span<float> metres() { return {metres_, count_}; }

  // Replaces metres by quanta, so metres() must not be used afterwards. Error if a height does not fit.
  Status quantise(double height_quantum_m, HeightRange& range) {
    range = {proto::kMaxHeight, -proto::kMaxHeight};
    for (size_t i = 0; i < count_; ++i) {
      const auto value = quantised(metres_[i], height_quantum_m);
      if (!value)
        return Error{ErrorCode::kLimit, "a height of " + std::to_string(metres_[i]) + " m does not fit steps of " +
                                            std::to_string(height_quantum_m) +
                                            " m; use a larger --vertical-step or name the void value with --nodata"};
      new (bytes_.get() + i * sizeof(float)) int32_t(*value);
      range = {std::min(range.lowest, *value), std::max(range.highest, *value)};
    }
    return {};
  }
  std::span<const int32_t> quanta() const {
    return {std::launder(reinterpret_cast<const int32_t*>(bytes_.get())), count_};
  }

 private:
  size_t count_;
  std::unique_ptr<std::byte[]> bytes_;
  float* metres_ = nullptr;
};

Status readAll(ElevationSource& source, HeightRaster& raster, const Progress& progress) {
  const ElevationInfo& info = source.info();
  const auto window = static_cast<uint32_t>(std::max<uint64_t>(1, kWindowSamples / info.width));
  progress.report("reading", 0);
  for (uint32_t row = 0; row < info.height; row += window) {
    if (!progress.keepGoing()) return stopped();
    const uint32_t count = std::min(window, info.height - row);
    const auto out =
        raster.metres().subspan(static_cast<size_t>(row) * info.width, static_cast<size_t>(count) * info.width);
    if (Status status = source.readRows(row, count, out); !status.ok()) return status;
    progress.report("reading", static_cast<double>(row + count) / info.height);
  }
  return {};
}

Status fill(HeightRaster& raster, const ElevationInfo& info, SceneOrigin& origin) {
  const VoidReport voids = fillVoids(raster.metres(), info.width, info.height);
  if (voids.all_void) return onlyVoids(info.title);
  origin.voids_filled = info.voids_filled + voids.samples;
  if (!voids.note.empty()) origin.notes.push_back(voids.note);
  return {};
}

// The height quantum: the user's, or a wider one that represents every height of the source exactly.
double chooseQuantum(std::span<const float> metres, const std::vector<EpochSamples>& epochs,
                     const BuildOptions& options, SceneOrigin& origin) {
  if (!options.widen_quantum) return options.height_quantum_m;
  for (const double quantum_m : {1.0, 0.5, 0.25}) {
    if (quantum_m <= options.height_quantum_m) break;
    const auto fits = [&](float h) { return !std::isfinite(h) || std::remainder(double{h}, quantum_m) == 0; };
    if (!std::all_of(metres.begin(), metres.end(), fits) ||
        !std::ranges::all_of(epochs, [&](const EpochSamples& e) { return std::ranges::all_of(e.metres, fits); }))
      continue;
    origin.notes.push_back(quantumNote(quantum_m));
    return quantum_m;
  }
  return options.height_quantum_m;
}

struct Terrain {
  const proto::GridTopology& grid;
  const proto::Frame& frame;
  Heights heights;
  const EpochLayers* epochs;  // null without any
};

// All but the first, which is laid over the source.
Result<std::vector<EpochSamples>> readEpochs(const BuildOptions& options, const ElevationInfo& info,
                                             const Progress& progress) {
  std::vector<EpochSamples> epochs;
  for (const EpochRequest& request : options.epochs) {
    if (!progress.keepGoing()) return stopped();
    auto epoch = readEpoch(request, info, epochs.empty() ? proto::LatticeWindow{} : wholeOf(info));
    if (!epoch) return epoch.error();
    epochs.push_back(std::move(*epoch));
  }
  return epochs;
}

Status addEpochs(const std::vector<EpochSamples>& epochs, EpochLayers& layers, const Progress& progress) {
  if (Status s = layers.begin(epochs.front()); !s.ok()) return s;
  for (size_t i = 1; i < epochs.size(); ++i) {
    const auto keepGoing = [&](double fraction) {
      progress.report("epochs", (static_cast<double>(i - 1) + fraction) / static_cast<double>(epochs.size() - 1));
      return progress.keepGoing();
    };
    if (Status s = layers.add(epochs[i], keepGoing); !s.ok()) return s;
  }
  progress.report("epochs", 1);
  return {};
}

BoundsOf boundsAtAllTimes(const Terrain& terrain) {
  if (!terrain.epochs) return boundsOver(HeightsByWindow::of(terrain.heights), terrain.frame);
  return boundsBetween(HeightsByWindow::of(terrain.epochs->lowest()), HeightsByWindow::of(terrain.epochs->highest()),
                       terrain.frame);
}

// Relief, unless the scene changes in time: it holds one ground only.
Status makeRelief(const Terrain& terrain, const BuildOptions& options, const Progress& progress, TileSection& section) {
  if (terrain.epochs) return {};
  const auto made =
      addRelief(HeightRows::of(terrain.heights), terrain.frame, options.threads, stage(progress, "relief"), section);
  if (!made) return made.error();
  return *made ? Status() : Status(stopped());
}

Status bound(const Terrain& terrain, unsigned threads, const SceneWriter& writer, const Progress& progress) {
  FirstFailure failure;
  const auto store = [&](proto::Slot first, std::span<const NodeRecord> records) {
    return failure.keep(writer.put(first, records));
  };
  progress.report("bounding", 0);
  const bool complete = computeBounds(
      {.grid = terrain.grid,
       .frame = terrain.frame,
       .heights = terrain.heights,
       .lowest = terrain.epochs ? terrain.epochs->lowest() : Heights{},
       .highest = terrain.epochs ? terrain.epochs->highest() : Heights{},
       .min_errors = terrain.epochs ? terrain.epochs->minErrors() : std::span<const proto::QuantisedError>{},
       .nodes = writer.nodes(),
       .threads = threads,
       .store = store,
       .onIdle = [&](std::span<const NodeRecord> nodes) { writer.release(nodes); },
       .onProgress =
           [&](double fraction) {
             progress.report("bounding", fraction);
             return progress.keepGoing();
           }});
  if (!failure.status().ok()) return failure.status();
  return complete ? Status() : Status(stopped());
}

Status checkOptions(const BuildOptions& options) {
  if (!(options.height_quantum_m > 0) || !std::isfinite(options.height_quantum_m))
    return Error{ErrorCode::kInvalidArgument, "the vertical step must be a positive number of metres"};
  if (options.epochs.empty() && options.epoch_blend != proto::EpochBlend::kLinear) return nothingToBlend();
  return {};
}

}  // namespace

Result<BuildReport> buildScene(ElevationSource& source, const BuildOptions& options, const Progress& progress) {
  if (Status status = checkOptions(options); !status.ok()) return status.error();
  if (source.sparse() != nullptr) return buildSparseScene(source, options, progress);
  const ElevationInfo& info = source.info();
  const auto grid = gridFor(info);
  if (!grid.ok()) return grid.error();
  const uint64_t samples = static_cast<uint64_t>(info.width) * info.height;
  HeightRaster raster(samples);
  if (!raster.allocated())
    return Error{ErrorCode::kLimit, info.title + ": " + std::to_string(samples * sizeof(float) >> 20) +
                                        " MiB of heights do not fit this machine's memory"};
  if (Status status = checkEpochs(options.epochs, info); !status.ok()) return status.error();
  if (Status status = readAll(*atFirstEpoch(source, options.epochs), raster, progress); !status.ok())
    return status.error();
  auto epochs = readEpochs(options, info, progress);
  if (!epochs) return epochs.error();
  progress.report("filling voids", 0);
  SceneOrigin origin{.title = info.title, .crs_wkt = info.crs_wkt, .notes = info.notes, .voids_filled = 0};
  const double height_quantum_m = chooseQuantum(raster.metres(), *epochs, options, origin);
  if (Status status = fill(raster, info, origin); !status.ok()) return status.error();
  progress.report("filling voids", 1);

  HeightRange range;
  if (Status status = raster.quantise(height_quantum_m, range); !status.ok())
    return Error{status.error().code, info.title + ": " + status.error().message};
  const Heights heights{raster.quanta(), info.width, info.height};
  proto::Frame frame = info.frame;
  frame.height_quantum_m = height_quantum_m;
  auto dates = datesOf(options.epochs, options.epoch_blend, grid->shape());
  if (!dates) return dates.error();
  auto objects = makeObjectSection(options.additions.objects, frame, *dates,
                                   groundOf(info, frame, [&](uint32_t x, uint32_t y) { return heights.row(y)[x]; }));
  if (!objects.ok()) return objects.error();
  auto offsets = EpochSection::create(options.output);
  if (!offsets) return offsets.error();
  std::optional<EpochLayers> layers;
  if (!epochs->empty()) {
    layers.emplace(*grid, frame, heights, *dates, *offsets, options.threads);
    if (Status s = addEpochs(*epochs, *layers, progress); !s.ok()) return s.error();
    range = layers->range();
  }
  const Terrain terrain{*grid, frame, heights, layers ? &*layers : nullptr};
  auto tiles = TileSection::create(options.output);
  if (!tiles) return tiles.error();
  if (Status s = makeRelief(terrain, options, progress, *tiles); !s.ok()) return s.error();
  ImageryReport imagery;
  const SceneAdditions& with = options.additions;
  if (with.picture) {
    auto made =
        addPicture(*with.picture, boundsAtAllTimes(terrain),
                   {with.imagery_quality, with.attribution, options.output, options.threads}, progress, origin, *tiles);
    if (!made) return made.error();
    imagery = *made;
  }
  auto writer = SceneWriter::create(options.output, {.shape = grid->shape(),
                                                     .frame = frame,
                                                     .heights = range,
                                                     .origin = origin,
                                                     .objects = std::move(*objects),
                                                     .epochs = &*offsets,
                                                     .epoch_blend = options.epoch_blend,
                                                     .datum = datumOf(info.vertical, info.inputs, height_quantum_m),
                                                     .page_coding = with.page_coding,
                                                     .threads = options.threads,
                                                     .tiles = &*tiles});
  if (!writer.ok()) return writer.error();
  fillBase(
      grid->shape(), [&](uint32_t x, uint32_t y) { return heights.clamped(x, y); }, *writer);

  if (Status status = bound(terrain, options.threads, *writer, progress); !status.ok()) return status.error();
  if (!progress.keepGoing()) return stopped();
  progress.report("writing", 0);
  const auto id = writer->finish();
  if (!id.ok()) return id.error();
  progress.report("writing", 1);
  return BuildReport{.width = info.width,
                     .height = info.height,
                     .samples = samples,
                     .voids_filled = origin.voids_filled,
                     .notes = origin.notes,
                     .height_quantum_m = height_quantum_m,
                     .levels = grid->maxLevel(),
                     .nodes = nodeCount(*grid),
                     .file_bytes = writer->fileBytes(),
                     .scene_id = *id,
                     .lowest_m = range.lowest * height_quantum_m,
                     .highest_m = range.highest * height_quantum_m,
                     .epochs = layers ? layers->reports() : std::vector<EpochReport>{},
                     .imagery = imagery,
                     .warnings = source.warnings()};
}

}  // namespace foreland::terrain
