// The terrain's least heights at any scene time along the lines of its lattice, for horizons (horizon.h): between two
// neighbouring vertices of a line, the straight line from one to the other lies nowhere above the terrain at full
// resolution.
//
// Level l has lines and vertices 2^l steps of the finest level apart. The finest level's vertices are the samples
// themselves if there are no more of them than allowed; where samples are left out, vertices are lowered until the
// lines between them lie below what was left out.
//
// In planar frames the lattice is an affine image of the ground plane. In geographic ones of up to 200 km from the
// middle the grid is a lattice of its own in the plane that touches the earth there, below the ground
// (tangent_heights.h). Over globes it is one about a place, in the plane that touches the globe there
// (globe_heights.h), with room for ground that is drawn elsewhere. Heights are kept in 65,536 steps between the least
// and the largest, rounded down. Immutable after creation; any thread. Memory: 5.4 bytes a vertex of the finest level.
#pragma once

#include <cstdint>
#include <glm/mat2x2.hpp>
#include <glm/vec2.hpp>
#include <memory>
#include <optional>
#include <vector>

#include "proto/imagery/tile.h"
#include "server/occlusion/horizon/globe_heights.h"
#include "server/occlusion/horizon/tangent_heights.h"
#include "server/section/hierarchy.h"

namespace foreland::server {

class HorizonGrid {
 public:
  static constexpr size_t kPadding = 8;  // heights after the last line, for reads of eight at a time
  // Which coordinate of the lattice changes along a line.
  enum class Along : uint8_t { kX, kY };
  struct Level {
    uint32_t lines[2], vertices[2];    // number of lines along x and y, and of vertices in each
    std::vector<uint16_t> heights[2];  // in steps(); line by line
    const uint16_t* line(Along along, uint32_t number) const {
      const auto a = static_cast<size_t>(along);
      return heights[a].data() + size_t{number} * vertices[a];
    }
  };

  struct Steps {
    double lowest_m = 0, step_m = 1;
    double metres(double height) const { return lowest_m + height * step_m; }
    double of(double metres) const { return (metres - lowest_m) / step_m; }
  };

  static constexpr size_t kMaxVertices = 8u << 20;
  // The hierarchy's frame must be planar. O(samples).
  explicit HorizonGrid(const Hierarchy& hierarchy, size_t max_vertices = kMaxVertices);
  // Of any frame; nullptr if the scene extends too far over the earth. O(samples).
  static std::shared_ptr<const HorizonGrid> of(const Hierarchy& hierarchy, size_t max_vertices = kMaxVertices);
  // Of a globe about a place.
  explicit HorizonGrid(const GlobeHeights& heights);

  // Whether the grid's lines are the lattice's.
  static bool supports(const Hierarchy& hierarchy) {
    return hierarchy.frame().transform().frame().kind == proto::FrameKind::kPlanar;
  }

  const std::vector<Level>& levels() const { return levels_; }
  const Steps& steps() const { return steps_; }
  // Steps of the finest level, and the horizontal position of them in these axes.
  glm::dvec2 toGrid(const glm::dvec2& scene_m) const { return to_grid_ * (scene_m - origin_m_); }
  glm::dvec2 directionToGrid(const glm::dvec2& scene_m) const { return to_grid_ * scene_m; }
  glm::dvec2 toScene(const glm::dvec2& direction) const { return to_scene_ * direction; }
  bool isLattice() const { return !geographic_ && !plane_; }  // its lines are the lattice's
  bool isOverGlobe() const { return plane_.has_value(); }
  // Of a position or a vector of the scene, in the axes of the grid: the scene's own, but over globes.
  glm::dvec3 toAxes(const glm::dvec3& scene_m) const { return plane_ ? plane_->point(scene_m) : scene_m; }
  glm::dvec3 directionToAxes(const glm::dvec3& scene_m) const { return plane_ ? plane_->direction(scene_m) : scene_m; }
  double stepsOfSample() const { return 1.0 / stride_; }  // of a lattice
  // What holds all ground of a box of the lattice between two heights: in steps, and up to a height of the scene.
  struct Bounds {
    glm::dvec2 low, high;
    double top_m;
  };
  Bounds boundsOf(const proto::LatticeBox& box, double lowest_m, double highest_m) const;
  // The same of a square of a geographic scene's lattice, between two heights in quanta, by the tables of its frame.
  Bounds boundsOf(const proto::FrameGrid& frame, const glm::uvec2& low, const glm::uvec2& high, int32_t lowest,
                  int32_t highest) const;
  // Of a circle of one metre on the ground, as steps, at most; and of a circle of one step, in metres.
  double stepsOfMetre() const { return steps_of_metre_; }
  double metresOfStep() const { return metres_of_step_; }
  double heightQuantum() const { return quantum_m_; }  // metres
  double highest() const { return highest_m_; }        // of the heights, metres
  size_t bytes() const;

 private:
  HorizonGrid(const Hierarchy& hierarchy, const TangentHeights& heights);
  void setAxes(const glm::dmat2& step, const glm::dvec2& origin_m);
  Bounds boundsAbout(const glm::dvec3& low, const glm::dvec3& high) const;

  std::optional<proto::FrameTransform> geographic_;  // of geographic frames
  std::optional<LocalPlane> plane_;                  // of globes
  uint32_t stride_ = 1;                              // samples a step
  glm::dmat2 to_grid_{1}, to_scene_{1};              // of vectors; in steps
  glm::dvec2 origin_m_{0};                           // of sample (0, 0)
  double steps_of_metre_ = 1, metres_of_step_ = 1, highest_m_ = 0, quantum_m_ = 1;
  Steps steps_;
  std::vector<Level> levels_;
};

}  // namespace foreland::server
