// What is known of one node of a surface, at its slot: where it is, and the bounds of leaving it out
// (terrain/surface/bounds.h says what they hold). 24 bytes. Every bound is rounded outward about what is stored, so a
// decoded record keeps what was guaranteed. Value types; any thread; portable to WebAssembly.
#pragma once

#include <bit>
#include <cmath>
#include <cstdint>
#include <glm/vec3.hpp>

namespace foreland::proto {

// What bounds the error vectors of a node: a body of revolution about the node's normal, symmetric about the origin.
//
//   spheroid  semi-axis `along` the normal and `across` it (S 3.3.3)
//   Hoppe's   the hull of a sphere of radius `across` and of two points at `along` on the normal: a sphere with two
//             cones (Hoppe, "View-dependent refinement of progressive meshes", 1997, section 4; S figure 4); for comparison
enum class ErrorShape : uint8_t { kSpheroid, kHoppe };

// Non-negative metres in 16 bits: eight bits of a float's exponent and eight of its mantissa, rounded up (by 2^-8 at
// most).
struct CompactBound {
  uint16_t bits = 0;

  static CompactBound roundUp(double metres);  // not negative
  float metres() const { return std::bit_cast<float>(static_cast<uint32_t>(bits) << 15); }
  bool operator==(const CompactBound&) const = default;
};

// A direction in 32 bits: the octahedron unfolded onto a square of 2^16 a side (Cigolle et al., "A survey of efficient
// representations for independent unit vectors", 2014). Within 7e-5 rad of what was packed.
struct CompactNormal {
  int16_t x = 0, y = 0;

  static CompactNormal pack(const glm::dvec3& n);  // not zero
  glm::dvec3 unpack() const {
    double u = x / 32767.0, v = y / 32767.0;
    const double w = 1 - std::fabs(u) - std::fabs(v), fold = std::fmax(-w, 0);
    u -= std::copysign(fold, u);
    v -= std::copysign(fold, v);
    const double inverse = 1 / std::sqrt(u * u + v * v + w * w);
    return {u * inverse, v * inverse, w * inverse};
  }
  bool operator==(const CompactNormal&) const = default;
};

// A share of 1 in 8 bits, squared so that small ones keep their digits; rounded up. 1 stands for more, too.
struct CompactShare {
  uint8_t root = 0;

  static CompactShare roundUp(double share);  // not negative
  double value() const { return root * root / 65025.0; }
  bool isFull() const { return root == 255; }
  bool operator==(const CompactShare&) const = default;
};

// Largest coordinate of a node's position, in quanta: differences of positions fit 32 bits.
inline constexpr int32_t kMaxObjectQuanta = 1 << 28;

struct SurfaceRecord {
  glm::ivec3 position{0};    // quanta
  CompactBound radius;       // of the sphere about `position` that holds the support, true and drawn
  CompactBound error_along;  // error shape about `normal`
  CompactBound error_across;
  CompactShare cone_sine;  // of half the opening of a cone about `normal` that holds the normals of the support's
                           // triangles; full for a right angle or more
  CompactShare bulge;      // how far those triangles' planes may pass from `position`, as a share of the radius
  CompactNormal normal;
};
static_assert(sizeof(SurfaceRecord) == 24);

// A record, decoded; metres in the object's frame. Plain numbers, so that loops over columns of them vectorise.
struct SurfaceBounds {
  double x, y, z;                       // of the node
  double normal_x, normal_y, normal_z;  // unit
  double radius, bulge, sin_cone, along, across;

  static SurfaceBounds of(const SurfaceRecord& r, double quantum_m) {
    const glm::dvec3 p = glm::dvec3(r.position) * quantum_m, n = r.normal.unpack();
    const double radius = r.radius.metres();
    return {p.x,
            p.y,
            p.z,
            n.x,
            n.y,
            n.z,
            radius,
            r.bulge.value() * radius,
            r.cone_sine.value(),
            r.error_along.metres(),
            r.error_across.metres()};
  }
  glm::dvec3 position() const { return {x, y, z}; }
  glm::dvec3 normal() const { return {normal_x, normal_y, normal_z}; }
};

}  // namespace foreland::proto
