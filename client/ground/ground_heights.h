// Heights of the ground about the eye, as finely as a client knows them: from tiles of relief, from exact heights that
// the server was asked for, and else from the mesh. For what moves a camera and for read-outs; it shares nothing with
// what is drawn. One owner.
#pragma once

#include <cstdint>
#include <glm/vec2.hpp>
#include <optional>
#include <span>
#include <unordered_map>
#include <vector>

#include "proto/imagery/tile.h"
#include "proto/space/frame.h"

namespace foreland::client {

// A square of the lattice between four known heights, between which the ground is.
struct GroundCell {
  glm::dvec2 low;
  double side = 1;        // sample intervals
  double heights_m[4]{};  // south-west, south-east, north-west, north-east
  double coarse_m = 0;    // by how much the true heights may be above these
};

// Heights at samples, row by row from the south. NaN: beyond the data.
struct GroundPatch {
  glm::dvec2 low{0, 0};
  double spacing = 1;  // sample intervals
  uint32_t columns = 0;
  std::vector<float> heights_m{};
  uint32_t rows() const { return columns == 0 ? 0 : static_cast<uint32_t>(heights_m.size() / columns); }
};

class GroundHeights {
 public:
  // Forgets all; relief is of this layer from now on, if the scene has it.
  void enter(std::optional<proto::TileLayer> relief);

  // Heights of a tile in steps, as proto::decodeRelief gives them.
  void add(const proto::TileId& tile, std::vector<int32_t> steps);
  // Forgets tiles that are not among these.
  void keep(std::span<const uint64_t> keys);
  // Replaces the exact heights, and those of the mesh, which are the last choice.
  void setExact(GroundPatch patch) { exact_ = std::move(patch); }
  void setMesh(GroundPatch patch) { mesh_ = std::move(patch); }

  // The smallest cell that holds a lattice position; nothing if none is known. Which of two cells at their border is
  // not said.
  std::optional<GroundCell> cellAt(glm::dvec2 at) const;
  // Bilinear in that cell, metres above the zero surface.
  std::optional<double> heightAt(glm::dvec2 at) const;
  // How the ground rises there, metres a sample interval along x and along y.
  std::optional<glm::dvec2> gradientAt(glm::dvec2 at) const;

 private:
  std::optional<GroundCell> reliefCell(glm::dvec2 at) const;

  std::optional<proto::TileLayer> relief_;
  std::unordered_map<uint64_t, std::vector<int32_t>> tiles_;
  GroundPatch exact_, mesh_;
};

// The angle between ground that rises so and a level plane, radians.
double slopeOf(const proto::FrameTransform& frame, const proto::LatticePosition& at, glm::dvec2 gradient);

}  // namespace foreland::client
