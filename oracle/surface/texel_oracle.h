// The truth oracle for textures on surfaces: how far from where it belongs each texel is drawn. It fills triangles in
// the texture itself, by brute force: those of the full-resolution surface say where the centre of each texel belongs,
// those drawn say where it is, and both positions are projected. It knows triangles with texture coordinates, nothing
// of base faces, atlases, nodes or bounds, so whatever makes a texture slide is seen.
//
// A texel is on the silhouette if it lies on true triangles of which one faces the eye and another faces away, inside
// if all that it lies on face the eye; others are not seen on a closed surface. Otherwise as the oracle of vertices
// (surface_oracle.h).
//
// Immutable; any thread. Cost: about 10 ns per texel under each triangle.
#pragma once

#include <array>
#include <cstdint>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <span>
#include <vector>

#include "oracle/surface/surface_oracle.h"

namespace foreland::oracle {

struct TexturedTriangle {
  std::array<glm::dvec2, 3> texels{};  // texture coordinates in pixels from the upper left corner; centres at .5
  std::array<glm::dvec3, 3> positions{};
};

class TexelOracle {
 public:
  // `truth` counter-clockwise seen from outside; triangles share texture only along their edges. `width` and `height`
  // are the texture's.
  TexelOracle(std::vector<TexturedTriangle> truth, uint32_t width, uint32_t height, bool is_closed);

  SurfaceJudgement judge(std::span<const TexturedTriangle> drawn, const proto::Pose& pose, const proto::Lens& lens,
                         double near_m = 1e-3) const;
  uint64_t texels() const { return texels_; }  // that lie on the surface

 private:
  std::vector<TexturedTriangle> truth_;
  uint32_t width_, height_;
  bool is_closed_;
  std::vector<std::array<uint32_t, 2>> pairs_;  // texel and a true triangle that it lies on, sorted
  std::vector<glm::dvec3> positions_;           // of each texel, where it lies on any
  uint64_t texels_ = 0;
};

}  // namespace foreland::oracle
