// The six squares of a cube, glued along twelve edges, as one strip of a lattice (decision 0062). Face f has the
// lattice columns from f W on, W steps a side. Faces are laid and turned so that each edge of the cube is the west or
// south side of exactly one of its two faces: that face names the points of the edge. So every point has one name, in
// the half-open square x < W, y < W of a face; but for two of the eight corners, where only north or only east sides
// meet, which are named (0, W) and (6 W, 0).
//
//   faces 0, 2, 4   the east side is the west side of face f + 1; the north side, turned, the west side of face f + 2
//   faces 1, 3, 5   the north side is the south side of face f + 1; the east side, turned, the south side of face f + 2
//
// all modulo 6. Integers only; pure; any thread; O(1).
#pragma once

#include <algorithm>
#include <cstdint>

#include "proto/topology/node.h"

namespace foreland::proto {

// A point on the square of a face: 0 to W steps east and north of its lower left corner. Points on a side are on two
// squares, corners on three.
struct CubePlace {
  uint32_t face = 0;
  int32_t x = 0, y = 0;
  bool operator==(const CubePlace&) const = default;
};

// A vertex's places on the squares that hold it: two for points of edges, three for corners.
struct CubePlaces {
  CubePlace at[3];
  int count = 0;
  void push(const CubePlace& p) { at[count++] = p; }
  const CubePlace* begin() const { return at; }
  const CubePlace* end() const { return at + count; }
};

class Cube {
 public:
  static constexpr uint32_t kFaces = 6;

  explicit Cube(uint32_t side_log2) : log2_(side_log2), side_(1 << side_log2) {}

  int32_t side() const { return side_; }

  // Where a name's point is on the square that names it.
  CubePlace placeOf(NodeId n) const {
    const uint32_t face = std::min(n.x() >> log2_, kFaces - 1);
    return {face, static_cast<int32_t>(n.x() - (face << log2_)), static_cast<int32_t>(n.y())};
  }
  // Of a point on the face's square, its sides and corners included.
  [[gnu::noinline]] NodeId name(CubePlace p) const {
    if (p.x < side_ && p.y < side_) return nameWithin(p);
    const bool is_first = (p.face & 1) == 0;  // of the three that meet in one way
    if (p.x == side_ && p.y == side_) return nameWithin({after(p.face, 2), 0, 0});
    if (is_first) {
      if (p.x == side_) return nameWithin({after(p.face, 1), 0, p.y});
      return p.x == 0 ? NodeId::at(0, 1u << log2_) : nameWithin({after(p.face, 2), 0, side_ - p.x});
    }
    if (p.y == side_) return nameWithin({after(p.face, 1), p.x, 0});
    return p.y == 0 ? NodeId::at(kFaces << log2_, 0) : nameWithin({after(p.face, 2), side_ - p.y, 0});
  }

  // Whether the point, by its own name, lies on an edge or a corner of the cube.
  bool isOnSeam(NodeId n) const { return (n.x() & (static_cast<uint32_t>(side_) - 1)) == 0 || n.y() == 0; }
  // A vertex's place by its name, then those on other faces.
  [[gnu::noinline]] CubePlaces placesOf(NodeId n) const {
    const CubePlace own = placeOf(n);
    CubePlaces places;
    places.push(own);
    const bool is_first = (own.face & 1) == 0;
    if (own.x == side_ || own.y == side_) {  // one of the corners that no face names
      for (const uint32_t steps : {2u, 4u}) places.push({after(own.face, steps), own.x, own.y});
      return places;
    }
    if (own.x == 0)
      places.push(is_first ? CubePlace{before(own.face, 2), side_ - own.y, side_}
                           : CubePlace{before(own.face, 1), side_, own.y});
    if (own.y == 0)
      places.push(is_first ? CubePlace{before(own.face, 1), own.x, side_}
                           : CubePlace{before(own.face, 2), side_, side_ - own.x});
    return places;
  }
  bool isWithin(const CubePlace& p) const { return p.x >= 0 && p.y >= 0 && p.x <= side_ && p.y <= side_; }

  // The name of the point `dx` steps east and `dy` north of a named one on its square; or, from a point on an edge, on
  // the square beyond it, as if that were laid beside the first.
  NodeId moved(NodeId n, int32_t dx, int32_t dy) const {
    const CubePlace own = placeOf(n), there{own.face, own.x + dx, own.y + dy};
    if (isWithin(there)) return name(there);
    const CubePlace other = placesOf(n).at[1];
    const int quarters = quartersTo(own);
    if (quarters == 0) return name({other.face, other.x + dx, other.y + dy});
    return name({other.face, other.x - quarters * dy, other.y + quarters * dx});
  }

 private:
  NodeId nameWithin(const CubePlace& p) const {
    return NodeId::at((p.face << log2_) + static_cast<uint32_t>(p.x), static_cast<uint32_t>(p.y));
  }
  // By how many quarters the square beyond the edge on which a place lies by its name is turned: what points east on
  // the one points north on the other for 1, south for -1.
  static int quartersTo(const CubePlace& own) {
    const bool is_first = (own.face & 1) == 0;
    return own.x == 0 ? (is_first ? 1 : 0) : (is_first ? 0 : -1);
  }
  static uint32_t after(uint32_t face, uint32_t steps) { return (face + steps) % kFaces; }
  static uint32_t before(uint32_t face, uint32_t steps) { return (face + kFaces - steps) % kFaces; }

  uint32_t log2_;
  int32_t side_;
};

}  // namespace foreland::proto
