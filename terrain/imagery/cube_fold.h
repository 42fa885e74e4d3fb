// Where on a cube's faces (proto/topology/cube.h) a place lies that is beyond the side of one of them. Pure; any
// thread.
#pragma once

#include <algorithm>
#include <cstdint>
#include <glm/vec2.hpp>

#include "proto/imagery/tile.h"

namespace foreland::terrain {

// A place on a face's square: from (0, 0) in its lower left corner to its side.
struct FacePlace {
  uint32_t face = 0;
  double x = 0, y = 0;
};

// The square beyond the side, laid beside the face. A place that is within the face stays; one that is beyond two sides
// leaves the east or west one, and is beyond a side of the square there.
inline FacePlace foldedOver(const FacePlace& p, double side) {
  const bool is_first = p.face % 2 == 0;
  const auto on = [&](uint32_t steps, double x, double y) { return FacePlace{(p.face + steps) % 6, x, y}; };
  if (p.x >= side) return is_first ? on(1, p.x - side, p.y) : on(2, side - p.y, p.x - side);
  if (p.x < 0) return is_first ? on(4, side - p.y, side + p.x) : on(5, side + p.x, p.y);
  if (p.y >= side) return is_first ? on(2, p.y - side, side - p.x) : on(1, p.x, p.y - side);
  if (p.y < 0) return is_first ? on(5, p.x, side + p.y) : on(4, side + p.y, side - p.x);
  return p;
}

struct FaceTexel {
  uint32_t face = 0;
  int64_t x = 0, y = 0;
  bool operator==(const FaceTexel&) const = default;
  // Beyond how many sides of a face of so many texels.
  int beyond(int64_t side) const { return (x < 0 || x >= side ? 1 : 0) + (y < 0 || y >= side ? 1 : 0); }
};
inline FaceTexel foldedOver(const FaceTexel& t, int64_t side) {
  const FacePlace p =
      foldedOver({t.face, static_cast<double>(t.x) + 0.5, static_cast<double>(t.y) + 0.5}, static_cast<double>(side));
  return {p.face, static_cast<int64_t>(p.x), static_cast<int64_t>(p.y)};
}

// A part of a face's square that lies wholly beyond one side.
struct FaceBox {
  uint32_t face = 0;
  glm::dvec2 low{0}, high{0};
};
inline FaceBox foldedOver(const FaceBox& b, double side) {
  const glm::dvec2 middle = 0.5 * (b.low + b.high), half = 0.5 * (b.high - b.low);
  const FacePlace there = foldedOver(FacePlace{b.face, middle.x, middle.y}, side);
  const bool is_turned = there.face % 2 == b.face % 2;
  const glm::dvec2 size = is_turned ? glm::dvec2(half.y, half.x) : half, at(there.x, there.y);
  return {there.face, at - size, at + size};
}

}  // namespace foreland::terrain
