#include "terrain/imagery/relief.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <type_traits>
#include <vector>

#include "proto/imagery/relief_codec.h"
#include "terrain/geo/geodesy.h"
#include "terrain/imagery/ground_bounds.h"
#include "terrain/imagery/relief_steps.h"
#include "terrain/parallel.h"

namespace foreland::terrain {

namespace {

constexpr double kStepsBetweenSamples = 20;
constexpr double kLargestStep_m = 10;

// Some rows of one level, in quanta. Heights of samples are whole, those of means need not be.
template <class T>
struct Band {
  uint32_t width = 0, height = 0;  // of the level
  uint32_t first = 0, end = 0;     // rows that are here
  std::vector<T> values{};
  const T* row(uint32_t y) const {
    return values.data() + static_cast<size_t>(std::min(y, height - 1) - first) * width;
  }
};

template <class T>
std::span<uint8_t> bytesOf(std::span<T> values) {
  return {reinterpret_cast<uint8_t*>(values.data()), values.size_bytes()};
}

// Rows [first, end) of means of 2 x 2; at odd sizes the border counts twice.
template <class T>
std::vector<float> halve(const Band<T>& fine, uint32_t first, uint32_t end) {
  const uint32_t width = (fine.width + 1) / 2;
  std::vector<float> coarse(static_cast<size_t>(width) * (end - first));
  float* out = coarse.data();
  for (uint32_t y = first; y < end; ++y) {
    const T *south = fine.row(2 * y), *north = fine.row(2 * y + 1);
    for (uint32_t x = 0; x < width; ++x) {
      const uint32_t west = 2 * x, east = std::min(2 * x + 1, fine.width - 1);
      const auto sum = [&](const T* row) { return static_cast<double>(row[west]) + static_cast<double>(row[east]); };
      *out++ = static_cast<float>(0.25 * (sum(south) + sum(north)));
    }
  }
  return coarse;
}

// Makes the tiles of one layer, level by level, and each level by rows of tiles.
class ReliefMaker {
 public:
  ReliefMaker(const HeightRows& heights, const proto::Frame& frame, unsigned threads, const KeepGoing& keepGoing,
              TileSection& section, uint8_t layer, SpoolFile& means)
      : heights_(heights),
        frame_(frame),
        section_(section),
        layer_index_(layer),
        layer_(section.layer(layer)),
        threads_(threads),
        keepGoing_(keepGoing),
        means_(means),
        all_(tileCount(layer_)) {}

  Result<bool> make() {
    if (!addLevel<int32_t>(0)) return finish();
    for (uint32_t level = 1; level < layer_.levels(); ++level)
      if (!addLevel<float>(static_cast<uint8_t>(level))) return finish();
    return finish();
  }

 private:
  struct Scratch {
    std::vector<int32_t> steps;
    std::vector<glm::dvec3> positions;
  };

  Result<bool> finish() {
    if (!failure_.status().ok()) return failure_.status().error();
    return done_ == all_;
  }

  Status read(uint8_t, uint32_t first, uint32_t count, std::span<int32_t> out) {
    return heights_.read(first, count, out);
  }
  Status read(uint8_t level, uint32_t first, uint32_t, std::span<float> out) {
    return means_.read(means_at_ + uint64_t{first} * layer_.widthAt(level) * sizeof(float), bytesOf(out));
  }

  // The rows that a row of tiles needs: those that their gutters show, which is more than bounds of theirs look at.
  template <class T>
  Status load(uint8_t level, uint32_t tile_y, Band<T>& band) {
    const uint32_t low = tile_y * proto::kTilePayload;
    band.width = layer_.widthAt(level), band.height = layer_.heightAt(level);
    band.first = low - std::min(low, proto::kTileGutter);
    band.end = std::min(low + proto::kTilePayload + proto::kTileGutter, band.height);
    band.values.resize(size_t{band.end - band.first} * band.width);
    return read(level, band.first, band.end - band.first, band.values);
  }

  // Appends what these tiles show to the next level.
  template <class T>
  Status keepMeans(uint8_t level, uint32_t tile_y, const Band<T>& band) {
    if (level + 1u >= layer_.levels()) return {};
    const uint32_t first = tile_y * (proto::kTilePayload / 2),
                   end = std::min(first + proto::kTilePayload / 2, layer_.heightAt(static_cast<uint8_t>(level + 1)));
    std::vector<float> rows = halve(band, first, end);
    const auto offset = means_.append(bytesOf(std::span(rows)));
    return offset ? Status() : Status(offset.error());
  }

  template <class T>
  bool addLevel(uint8_t level) {
    const uint64_t begin = means_.bytes();
    for (uint32_t tile_y = 0; tile_y < layer_.tilesY(level); ++tile_y) {
      Band<T> band;
      if (!failure_.keep(load(level, tile_y, band)) || !failure_.keep(keepMeans(level, tile_y, band))) return false;
      if (!addRow(level, tile_y, band)) return false;
    }
    means_at_ = begin;
    return true;
  }

  template <class T>
  bool addRow(uint8_t level, uint32_t tile_y, const Band<T>& band) {
    std::optional<GroundBounds> ground;
    if constexpr (std::is_same_v<T, int32_t>)
      ground.emplace(HeightsByWindow::of({band.values, band.width, band.height, 0, band.first}), frame_);
    const uint32_t count = layer_.tilesX(level);
    std::vector<Scratch> scratch(threadCount(threads_));
    const bool complete = parallelFor(
        count, threads_,
        [&](uint64_t x, unsigned worker) {
          const proto::TileId tile{layer_index_, level, static_cast<uint32_t>(x), tile_y};
          takeReliefSteps(
              layer_, tile, frame_.height_quantum_m, [&](uint32_t at_x, uint32_t at_y) { return band.row(at_y)[at_x]; },
              scratch[worker].steps);
          const proto::TileBounds bounds =
              ground ? ground->over(layer_.boxOf(tile), scratch[worker].positions).value() : boundsOf(tile);
          failure_.keep(section_.add(tile, proto::encodeRelief(scratch[worker].steps), bounds, 0));
        },
        [&](uint64_t done) { return keepGoing_(static_cast<double>(done_ + done) / static_cast<double>(all_)); });
    if (complete) done_ += count;
    return complete && failure_.status().ok();
  }

  proto::TileBounds boundsOf(const proto::TileId& tile) const {
    std::vector<proto::TileBounds> children;
    for (uint32_t k = 0; k < 4; ++k) {
      const proto::TileId child = tile.child(k);
      if (layer_.has(child)) children.push_back(section_.bounds(child));
    }
    return unionOf(std::span<const proto::TileBounds>(children));
  }

  const HeightRows& heights_;
  const proto::Frame& frame_;
  TileSection& section_;
  uint8_t layer_index_;
  const proto::TileLayer layer_;
  unsigned threads_;
  const KeepGoing& keepGoing_;
  SpoolFile& means_;       // of one level after the other
  uint64_t means_at_ = 0;  // the current level's begin
  uint64_t all_, done_ = 0;
  FirstFailure failure_;
};

}  // namespace

HeightRows HeightRows::of(const Heights& heights) {
  return {heights.width, heights.height, [heights](uint32_t first, uint32_t count, std::span<int32_t> out) {
            std::copy_n(heights.row(first), size_t{count} * heights.width, out.begin());
            return Status();
          }};
}

proto::TileLayer reliefLayer(uint32_t width, uint32_t height, const proto::Frame& frame) {
  const glm::dvec2 spacing_m = sampleSpacing(frame, width, height);
  const double wanted_m = std::min(std::min(spacing_m.x, spacing_m.y) / kStepsBetweenSamples, kLargestStep_m);
  // A quantum of 0.1 m goes five times into 0.5 m, whatever rounding says.
  const double quanta = std::max(1.0, std::floor(wanted_m / frame.height_quantum_m * (1 + 1e-9)));
  return {.content = proto::TileContent::kRelief,
          .coding = proto::TileCoding::kHeights,
          .width = width,
          .height = height,
          .origin = {-0.5, -0.5},
          .texel = 1,
          .step_m = quanta * frame.height_quantum_m,
          .attribution = {}};
}

Result<bool> addRelief(const HeightRows& heights, const proto::Frame& frame, unsigned threads,
                       const KeepGoing& keepGoing, TileSection& section) {
  const proto::TileLayer layer = reliefLayer(heights.width, heights.height, frame);
  if (Status s = layer.validate(); !s.ok()) return s.error();
  auto means = section.scratch();
  if (!means) return means.error();
  const uint8_t index = section.addLayer(layer);
  return ReliefMaker(heights, frame, threads, keepGoing, section, index, *means).make();
}

}  // namespace foreland::terrain
