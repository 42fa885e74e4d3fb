// Small scenes from formulas, through the real builder and the real file: what a test sees is what a server sees.
#pragma once

#include <gtest/gtest.h>

#include <atomic>
#include <cmath>
#include <filesystem>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "base/rng.h"
#include "terrain/pipeline/build.h"
#include "terrain/store/scene.h"
#include "tests/support/files.h"

namespace foreland::test {

// Height in metres at a lattice position; NaN is a void.
using HeightFunction = std::function<double(uint32_t x, uint32_t y)>;

// Spacing 10 m, planar with the origin in the middle of the south-west quarter, or three arc seconds in the Alps.
inline proto::Frame makeFrame(proto::FrameKind kind, uint32_t width, uint32_t height) {
  proto::Frame frame;
  frame.kind = kind;
  frame.anchor = {std::floor(width / 2.0), std::floor(height / 2.0)};
  frame.axis_x_m = {10, 0};
  frame.axis_y_m = {0, 10};
  if (kind == proto::FrameKind::kPlanar) return frame;
  constexpr double kDegree = 0.017453292519943295;
  frame.latitude0_rad = 46 * kDegree;
  frame.longitude0_rad = 8 * kDegree;
  frame.latitude_step_rad = frame.longitude_step_rad = kDegree / 1200;
  frame.origin = {frame.latitude0_rad + 0.5 * height * frame.latitude_step_rad,
                  frame.longitude0_rad + 0.5 * width * frame.longitude_step_rad, 0};
  return frame;
}

class FormulaSource : public terrain::ElevationSource {
 public:
  FormulaSource(uint32_t width, uint32_t height, HeightFunction formula,
                proto::FrameKind kind = proto::FrameKind::kPlanar)
      : formula_(std::move(formula)) {
    info_.width = width;
    info_.height = height;
    info_.frame = makeFrame(kind, width, height);
    info_.title = "formula";
  }
  const terrain::ElevationInfo& info() const override { return info_; }
  terrain::ElevationInfo& info() { return info_; }
  Status readRows(uint32_t first, uint32_t count, std::span<float> out) override {
    size_t i = 0;
    for (uint32_t y = first; y < first + count; ++y)
      for (uint32_t x = 0; x < info_.width; ++x) out[i++] = static_cast<float>(formula_(x, y));
    return {};
  }

 private:
  terrain::ElevationInfo info_;
  HeightFunction formula_;
};

// Hills over several octaves with some noise, between about 0 and 1200 m; the same for the same seed.
inline HeightFunction hills(uint64_t seed) {
  Rng rng(seed);
  struct Wave {
    double kx, ky, phase, metres;
  };
  std::vector<Wave> waves;
  for (int octave = 0; octave < 6; ++octave) {
    const double frequency = 0.02 * std::exp2(octave), angle = rng.uniform(0, 6.2831853);
    waves.push_back(
        {frequency * std::cos(angle), frequency * std::sin(angle), rng.uniform(0, 6.2831853), 300 / std::exp2(octave)});
  }
  return [waves, seed](uint32_t x, uint32_t y) {
    double metres = 600;
    for (const Wave& w : waves) metres += w.metres * std::sin(w.kx * x + w.ky * y + w.phase);
    return metres + Rng(seed ^ (static_cast<uint64_t>(y) << 32 | x)).uniform(-3, 3);
  };
}

// Independent random samples: the roughest terrain possible.
inline HeightFunction noise(uint64_t seed, double metres) {
  return [seed, metres](uint32_t x, uint32_t y) {
    return Rng(seed ^ (static_cast<uint64_t>(y) << 32 | x)).uniform(0, metres);
  };
}

// Builds and opens a scene file and removes its name; the scene exists as long as it is referenced. Aborts the test on
// failure.
inline std::shared_ptr<const terrain::Scene> makeScene(terrain::ElevationSource& source, double height_quantum_m = 0.1,
                                                       unsigned threads = 1,
                                                       std::vector<terrain::EpochRequest> epochs = {},
                                                       proto::EpochBlend blend = proto::EpochBlend::kLinear) {
  const TemporaryFolder folder;
  const auto report = terrain::buildScene(source, {.output = folder / "scene.fls",
                                                   .height_quantum_m = height_quantum_m,
                                                   .threads = threads,
                                                   .epochs = std::move(epochs),
                                                   .epoch_blend = blend});
  if (!report.ok()) std::fprintf(stderr, "makeScene: %s\n", report.error().message.c_str());
  CHECK_TRUE(report.ok());
  const auto scene = terrain::Scene::open(folder / "scene.fls");
  CHECK_TRUE(scene.ok());
  return *scene;
}

inline std::shared_ptr<const terrain::Scene> makeScene(uint32_t width, uint32_t height, const HeightFunction& formula,
                                                       proto::FrameKind kind = proto::FrameKind::kPlanar) {
  FormulaSource source(width, height, formula, kind);
  return makeScene(source);
}

inline std::shared_ptr<const terrain::Scene> makeScene(uint32_t width, uint32_t height, uint64_t seed,
                                                       proto::FrameKind kind = proto::FrameKind::kPlanar) {
  return makeScene(width, height, hills(seed), kind);
}

// A window of formula terrain, as an epoch of it: the same lattice, and heights by their place on the whole.
inline FormulaSource windowSource(const FormulaSource& whole, const proto::LatticeWindow& w, HeightFunction formula) {
  FormulaSource source(w.width, w.height,
                       [w, formula = std::move(formula)](uint32_t x, uint32_t y) { return formula(w.x + x, w.y + y); });
  proto::Frame frame = whole.info().frame;
  frame.anchor -= glm::dvec2(w.x, w.y);
  frame.latitude0_rad += w.y * frame.latitude_step_rad;
  frame.longitude0_rad += w.x * frame.longitude_step_rad;
  source.info().frame = frame;
  return source;
}

// Hills of which some windows change by bumps, from epoch to epoch, a hundred days apart, or unless the blend is linear
// 20 to 180; the same for the same seed.
inline std::shared_ptr<const terrain::Scene> makeMovingScene(uint32_t width, uint32_t height, uint64_t seed,
                                                             size_t epochs,
                                                             proto::FrameKind kind = proto::FrameKind::kPlanar,
                                                             proto::EpochBlend blend = proto::EpochBlend::kLinear) {
  Rng rng(seed);
  FormulaSource whole(width, height, hills(seed), kind);
  std::vector<FormulaSource> sources;
  std::vector<terrain::EpochRequest> requests;
  for (size_t i = 0; i < epochs; ++i) {
    const auto x = static_cast<uint32_t>(rng.below(width - 1)), y = static_cast<uint32_t>(rng.below(height - 1));
    const proto::LatticeWindow window{x, y, static_cast<uint32_t>(1 + rng.below(width - x)),
                                      static_cast<uint32_t>(1 + rng.below(height - y))};
    const double metres = i == 0 ? 0 : rng.uniform(-150, 150), rough = rng.uniform(0, 10);
    sources.push_back(windowSource(whole, window, [=, ground = hills(seed)](uint32_t at_x, uint32_t at_y) {
      const double u = (at_x - window.x + 0.5) / window.width - 0.5, v = (at_y - window.y + 0.5) / window.height - 0.5;
      const double bump = metres * std::exp(-8 * (u * u + v * v));
      return (at_x + 3 * at_y) % 17 == 0
                 ? std::numeric_limits<double>::quiet_NaN()
                 : ground(at_x, at_y) + bump +
                       (i == 0 ? 0 : Rng(seed ^ at_x << 20 ^ at_y ^ i << 40).uniform(-rough, rough));
    }));
  }
  Time date;
  for (size_t i = 0; i < epochs; ++i) {
    requests.push_back({date, std::to_string(i), &sources[i]});
    const int64_t days = blend == proto::EpochBlend::kLinear ? 100 : 20 + static_cast<int64_t>(rng.below(161));
    date = date + Duration{days * 86'400'000'000};
  }
  return makeScene(whole, 0.1, 1, std::move(requests), blend);
}

}  // namespace foreland::test
