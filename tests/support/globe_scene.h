// Small planets from formulas, through the real builder and the real file.
#pragma once

#include <cmath>
#include <functional>
#include <glm/geometric.hpp>
#include <memory>
#include <utility>
#include <vector>

#include "terrain/pipeline/sparse_build.h"
#include "tests/support/scene.h"

namespace foreland::test {

// Of a planet of 20 km, as flat as Saturn, so that everything that bends does so within a few kilometres.
inline proto::Frame makeGlobeFrame(uint32_t face_log2) {
  proto::Frame frame;
  frame.kind = proto::FrameKind::kGlobe;
  frame.semi_major_m = 20'000;
  frame.flattening = 0.09;
  frame.face_steps = 1u << face_log2;
  frame.height_quantum_m = 0.1;
  return frame;
}

// Each component between -1 and 1. They are drawn in this order whatever the compiler: golden streams are of them.
inline glm::dvec3 globeWave(Rng& rng) {
  const double z = rng.uniform(-1, 1), y = rng.uniform(-1, 1), x = rng.uniform(-1, 1);
  return {x, y, z};
}

// Metres by direction, between about -150 and 450; the same for the same seed.
inline double globeHills(uint64_t seed, const glm::dvec3& direction) {
  Rng rng(seed);
  double metres = 150;
  for (int octave = 0; octave < 6; ++octave) {
    const glm::dvec3 wave = globeWave(rng);
    metres +=
        120 / std::exp2(octave) * std::sin(glm::dot(wave, direction) * 6 * std::exp2(octave) + rng.uniform(0, 6.28));
  }
  return metres;
}

using GlobeRelief = std::function<double(const glm::dvec3& direction)>;  // metres

// Ridges and valleys about two kilometres apart, as high as mountains on a planet of 20 km can be; by direction.
inline double globeRidges(uint64_t seed, const glm::dvec3& direction) {
  Rng rng(seed);
  double metres = 0;
  for (int i = 0; i < 3; ++i) {
    const glm::dvec3 wave = globeWave(rng);
    metres += 130 * std::sin(glm::dot(glm::normalize(wave), direction) * 60 + rng.uniform(0, 6.28));
  }
  return metres + 0.1 * globeHills(seed, direction);
}

// A file of a planet with faces of 2^face_log2 steps a side, whole but for so many of the finest levels, which are
// there around one corner of the cube and one pole. It states that it was made of `inputs`. Aborts the test on failure.
inline std::filesystem::path globeFile(const TemporaryFolder& folder, uint32_t face_log2, const GlobeRelief& relief,
                                       uint32_t sparse_levels, std::vector<terrain::SceneInput> inputs = {}) {
  const proto::GridTopology grid =
      *proto::GridTopology::create(proto::GridTopology::cubeShape(face_log2, sparse_levels));
  const proto::Frame frame = makeGlobeFrame(face_log2);
  const proto::FrameGrid positions(frame, grid.maxX(), grid.maxY());
  const auto quanta = [&](proto::NodeId v) {
    return static_cast<int32_t>(std::nearbyint(relief(glm::normalize(positions.position(v, 0))) * 10));
  };
  std::vector<proto::Slot> deep;
  if (sparse_levels > 0) {
    const uint32_t side = grid.rootSize();
    for (const proto::NodeId near : {proto::NodeId::at(1, 1), proto::NodeId::at(2 * side + side / 2 + 1, side / 2 + 1)})
      deep.push_back(grid.slot(near));
  }
  const std::filesystem::path file = folder / "globe.fls";
  terrain::SceneOrigin origin;
  origin.title = "globe";
  terrain::SceneDatum datum{.vertical = {}, .inputs = std::move(inputs)};
  for (terrain::SceneInput& input : datum.inputs) input.window = {0, 0, grid.maxX() + 1, grid.maxY() + 1};
  const auto report = terrain::buildSparseScene({grid, frame, deep, quanta}, {file, 1, origin, std::move(datum)});
  if (!report.ok()) std::fprintf(stderr, "globeFile: %s\n", report.error().message.c_str());
  CHECK_TRUE(report.ok());
  return file;
}

inline std::filesystem::path globeFile(const TemporaryFolder& folder, uint32_t face_log2, uint64_t seed,
                                       uint32_t sparse_levels, std::vector<terrain::SceneInput> inputs = {}) {
  return globeFile(
      folder, face_log2, [seed](const glm::dvec3& direction) { return globeHills(seed, direction); }, sparse_levels,
      std::move(inputs));
}

// The scene of such a file, which has no name any more.
inline std::shared_ptr<const terrain::Scene> makeGlobeScene(uint32_t face_log2, const GlobeRelief& relief,
                                                            uint32_t sparse_levels = 0,
                                                            std::vector<terrain::SceneInput> inputs = {}) {
  const TemporaryFolder folder;
  const auto scene = terrain::Scene::open(globeFile(folder, face_log2, relief, sparse_levels, std::move(inputs)));
  CHECK_TRUE(scene.ok());
  return *scene;
}
inline std::shared_ptr<const terrain::Scene> makeGlobeScene(uint32_t face_log2, uint64_t seed,
                                                            uint32_t sparse_levels = 0,
                                                            std::vector<terrain::SceneInput> inputs = {}) {
  return makeGlobeScene(
      face_log2, [seed](const glm::dvec3& direction) { return globeHills(seed, direction); }, sparse_levels,
      std::move(inputs));
}

}  // namespace foreland::test
