// What bounds the ground within a tile, at full resolution: its heights and its normals, in the scene's axes.
// Immutable; any thread, each with scratch of its own.
#pragma once

#include <functional>
#include <glm/vec3.hpp>
#include <span>
#include <utility>
#include <vector>

#include "base/result.h"
#include "proto/imagery/tile.h"
#include "proto/space/frame_grid.h"
#include "terrain/bounds/heights.h"

namespace foreland::terrain {

struct SampleWindow {
  uint32_t x = 0, y = 0, width = 0, height = 0;
};

// The heights of a scene's samples, quanta, however they are kept.
struct HeightsByWindow {
  uint32_t width = 0, height = 0;  // samples
  // Fills `out` with a window's, row by row from the south. Any thread.
  std::function<Status(const SampleWindow& window, std::span<int32_t> out)> read;

  static HeightsByWindow of(const Heights& heights);
};

class GroundBounds {
 public:
  static constexpr uint32_t kSamplesAtOnce = 1u << 19;

  GroundBounds(HeightsByWindow heights, const proto::Frame& frame, uint32_t samples_at_once = kSamplesAtOnce)
      : heights_(std::move(heights)),
        samples_at_once_(samples_at_once),
        height_quantum_m_(frame.height_quantum_m),
        grid_(frame, heights_.width - 1, heights_.height - 1) {}

  // Of the ground over a rectangle of the lattice, whether surface or normals are interpolated bilinearly or taken from
  // differences between neighbours. O(samples); not slower than 10^7 samples a second. Memory: 28 bytes for each sample
  // that is held at once, or for two rows of them. An Error is that of reading heights.
  Result<proto::TileBounds> over(const proto::LatticeBox& box, std::vector<glm::dvec3>& scratch) const;

 private:
  SampleWindow windowOver(const proto::LatticeBox& box) const;  // at least 2 x 2
  template <class Visit>
  Status forEachStrip(const SampleWindow& window, std::vector<int32_t>& quanta, std::vector<glm::dvec3>& positions,
                      const Visit& visit) const;

  HeightsByWindow heights_;
  uint32_t samples_at_once_;
  double height_quantum_m_;
  proto::FrameGrid grid_;
};

// Bounds that hold all of `parts`, of which there is one at least.
proto::TileBounds unionOf(std::span<const proto::TileBounds> parts);

}  // namespace foreland::terrain
