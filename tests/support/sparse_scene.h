// Small scenes from formulas whose finest levels are there only in places, through the real builder and the real file.
#pragma once

#include <algorithm>
#include <memory>

#include "terrain/pipeline/sparse_build.h"
#include "tests/support/scene.h"

namespace foreland::test {

// A disc of the lattice.
struct Disc {
  double x, y, radius;

  bool meets(const proto::LatticeWindow& w) const {
    const double dx = std::clamp<double>(x, w.x, w.x + w.width - 1.0) - x,
                 dy = std::clamp<double>(y, w.y, w.y + w.height - 1.0) - y;
    return dx * dx + dy * dy <= radius * radius;
  }
};

// Whole down to a spacing of 2^whole_log2 samples, and as fine as the lattice where one of some discs is. Aborts the
// test on failure.
inline std::shared_ptr<const terrain::Scene> makeSparseScene(
    uint32_t width, uint32_t height, const HeightFunction& formula, proto::FrameKind kind, uint32_t whole_log2,
    const std::vector<Disc>& deep, terrain::PageCoding page_coding = terrain::PageCoding::kPlain) {
  const proto::GridTopology grid = *terrain::sparseGrid(width, height, whole_log2);
  proto::Frame frame = makeFrame(kind, width, height);
  frame.height_quantum_m = 0.1;
  const auto quanta = [&](proto::NodeId v) {
    return static_cast<int32_t>(std::nearbyint(formula(std::min(v.x(), width - 1), std::min(v.y(), height - 1)) * 10));
  };
  const auto isWanted = [&](uint32_t, const proto::LatticeWindow& tile) {
    return std::ranges::any_of(deep, [&](const Disc& disc) { return disc.meets(tile); });
  };
  const TemporaryFolder folder;
  terrain::SceneOrigin origin;
  origin.title = "sparse";
  const auto report = terrain::buildSparseScene({grid, frame, terrain::pagesWhere(grid, isWanted), quanta},
                                                {folder / "scene.fls", 1, origin, {}, page_coding});
  if (!report.ok()) std::fprintf(stderr, "makeSparseScene: %s\n", report.error().message.c_str());
  CHECK_TRUE(report.ok());
  const auto scene = terrain::Scene::open(folder / "scene.fls");
  CHECK_TRUE(scene.ok());
  return *scene;
}

}  // namespace foreland::test
