#include "terrain/imagery/relief.h"

#include <algorithm>
#include <cmath>
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

// Heights of one level in quanta. Those of the samples are whole, those of means need not be.
template <class T>
struct LevelView {
  const T* at;
  uint32_t width, height;
  const T* row(uint32_t y) const { return at + static_cast<size_t>(std::min(y, height - 1)) * width; }
};

// Means of 2 x 2; at odd sizes the border counts twice.
template <class T>
std::vector<float> halve(const LevelView<T>& fine, unsigned threads) {
  const uint32_t width = (fine.width + 1) / 2, height = (fine.height + 1) / 2;
  std::vector<float> coarse(static_cast<size_t>(width) * height);
  const auto halveRow = [&](uint64_t y, unsigned) {
    const T *south = fine.row(static_cast<uint32_t>(2 * y)), *north = fine.row(static_cast<uint32_t>(2 * y + 1));
    float* out = &coarse[y * width];
    for (uint32_t x = 0; x < width; ++x) {
      const uint32_t west = 2 * x, east = std::min(2 * x + 1, fine.width - 1);
      const auto sum = [&](const T* row) { return static_cast<double>(row[west]) + static_cast<double>(row[east]); };
      out[x] = static_cast<float>(0.25 * (sum(south) + sum(north)));
    }
  };
  parallelFor(height, threads, halveRow, [](uint64_t) { return true; });
  return coarse;
}

// Makes the tiles of one layer, level by level.
class ReliefMaker {
 public:
  ReliefMaker(const Heights& heights, const proto::Frame& frame, unsigned threads, const KeepGoing& keepGoing,
              TileSection& section, uint8_t layer)
      : ground_(heights, frame),
        section_(section),
        layer_index_(layer),
        layer_(section.layer(layer)),
        height_quantum_m_(frame.height_quantum_m),
        threads_(threads),
        keepGoing_(keepGoing),
        all_(tileCount(layer_)) {}

  Result<bool> make(const Heights& heights) {
    if (!addLevel(0, LevelView<int32_t>{heights.quanta.data(), heights.width, heights.height})) return finish();
    std::vector<float> level;
    for (uint32_t at = 1; at < layer_.levels(); ++at) {
      const auto l = static_cast<uint8_t>(at);
      level = l == 1 ? halve(LevelView<int32_t>{heights.quanta.data(), heights.width, heights.height}, threads_)
                     : halve(view(level, static_cast<uint8_t>(l - 1)), threads_);
      if (!addLevel(l, view(level, l))) return finish();
    }
    return finish();
  }

 private:
  struct Scratch {
    std::vector<int32_t> steps;
    std::vector<glm::dvec3> positions;
  };

  LevelView<float> view(const std::vector<float>& level, uint8_t l) const {
    return {level.data(), layer_.widthAt(l), layer_.heightAt(l)};
  }
  Result<bool> finish() {
    if (!failure_.status().ok()) return failure_.status().error();
    return done_ == all_;
  }

  template <class T>
  bool addLevel(uint8_t level, const LevelView<T>& heights) {
    const uint32_t tiles_x = layer_.tilesX(level);
    const uint64_t count = uint64_t{tiles_x} * layer_.tilesY(level);
    std::vector<Scratch> scratch(threadCount(threads_));
    const bool complete = parallelFor(
        count, threads_,
        [&](uint64_t i, unsigned worker) {
          const proto::TileId tile{layer_index_, level, static_cast<uint32_t>(i % tiles_x),
                                   static_cast<uint32_t>(i / tiles_x)};
          takeReliefSteps(
              layer_, tile, height_quantum_m_, [&](uint32_t x, uint32_t y) { return heights.row(y)[x]; },
              scratch[worker].steps);
          failure_.keep(
              section_.add(tile, proto::encodeRelief(scratch[worker].steps), boundsOf(tile, scratch[worker]), 0));
        },
        [&](uint64_t done) { return keepGoing_(static_cast<double>(done_ + done) / static_cast<double>(all_)); });
    if (complete) done_ += count;
    return complete && failure_.status().ok();
  }

  proto::TileBounds boundsOf(const proto::TileId& tile, Scratch& scratch) const {
    if (tile.level == 0) return ground_.over(layer_.boxOf(tile), scratch.positions);
    std::vector<proto::TileBounds> children;
    for (uint32_t k = 0; k < 4; ++k) {
      const proto::TileId child = tile.child(k);
      if (layer_.has(child)) children.push_back(section_.bounds(child));
    }
    return unionOf(std::span<const proto::TileBounds>(children));
  }

  GroundBounds ground_;
  TileSection& section_;
  uint8_t layer_index_;
  const proto::TileLayer layer_;
  double height_quantum_m_;
  unsigned threads_;
  const KeepGoing& keepGoing_;
  uint64_t all_, done_ = 0;
  FirstFailure failure_;
};

}  // namespace

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

Result<bool> addRelief(const Heights& heights, const proto::Frame& frame, unsigned threads, const KeepGoing& keepGoing,
                       TileSection& section) {
  const proto::TileLayer layer = reliefLayer(heights.width, heights.height, frame);
  if (Status s = layer.validate(); !s.ok()) return s.error();
  const uint8_t index = section.addLayer(layer);
  return ReliefMaker(heights, frame, threads, keepGoing, section, index).make(heights);
}

}  // namespace foreland::terrain
