// What bounds the ground within a tile, at full resolution: its heights and its normals, in the scene's axes.
// Immutable; any thread, each with scratch of its own.
#pragma once

#include <glm/vec3.hpp>
#include <vector>

#include "proto/imagery/tile.h"
#include "proto/space/frame_grid.h"
#include "terrain/bounds/heights.h"

namespace foreland::terrain {

class GroundBounds {
 public:
  GroundBounds(const Heights& heights, const proto::Frame& frame)
      : heights_(heights),
        height_quantum_m_(frame.height_quantum_m),
        grid_(frame, heights.width - 1, heights.height - 1) {}

  // Of the ground over a rectangle of the lattice, whether surface or normals are interpolated bilinearly or taken from
  // differences between neighbours. O(samples); not slower than 10^7 samples a second.
  proto::TileBounds over(const proto::LatticeBox& box, std::vector<glm::dvec3>& scratch) const;

 private:
  struct Window {
    uint32_t x, y, width, height;  // samples; at least 2 x 2
  };
  Window windowOver(const proto::LatticeBox& box) const;
  void setHeights(const Window& window, proto::TileBounds& bounds) const;
  void setCone(const Window& window, std::vector<glm::dvec3>& positions, proto::TileBounds& bounds) const;

  Heights heights_;
  double height_quantum_m_;
  proto::FrameGrid grid_;
};

// Bounds that hold all of `parts`, of which there is one at least.
proto::TileBounds unionOf(std::span<const proto::TileBounds> parts);

}  // namespace foreland::terrain
