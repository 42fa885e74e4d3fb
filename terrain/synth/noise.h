// Gradient noise on integer hashes: the same numbers everywhere, no tables, no trigonometry. Pure functions; any
// thread. Perlin, "Improving noise" (2002), with its quintic fade; eight gradients.
#pragma once

#include <cmath>
#include <cstdint>

namespace foreland::terrain {

constexpr uint32_t hashLattice(int32_t x, int32_t y, uint32_t seed) {
  uint32_t h = static_cast<uint32_t>(x) * 0x8da6b343u ^ static_cast<uint32_t>(y) * 0xd8163841u ^ seed * 0xcb1ab31fu;
  h = (h ^ (h >> 15)) * 0x2c1b3c6du;
  h = (h ^ (h >> 12)) * 0x297a2d39u;
  return h ^ (h >> 15);
}

namespace noise_detail {

inline double gradient(uint32_t hash, double x, double y) {
  constexpr double kDiagonal = 0.70710678118654752;
  switch (hash >> 29) {
    case 0:
      return x;
    case 1:
      return -x;
    case 2:
      return y;
    case 3:
      return -y;
    case 4:
      return kDiagonal * (x + y);
    case 5:
      return kDiagonal * (x - y);
    case 6:
      return kDiagonal * (y - x);
    default:
      return -kDiagonal * (x + y);
  }
}

inline double fade(double t) { return t * t * t * (t * (t * 6 - 15) + 10); }

}  // namespace noise_detail

// Gradient noise: smooth, zero at lattice points, between about -0.7 and 0.7, with features of size 1.
inline double noise(double x, double y, uint32_t seed) {
  const double fx = std::floor(x), fy = std::floor(y);
  const auto ix = static_cast<int32_t>(fx), iy = static_cast<int32_t>(fy);
  const double u = x - fx, v = y - fy;
  using noise_detail::gradient;
  const double a = gradient(hashLattice(ix, iy, seed), u, v), b = gradient(hashLattice(ix + 1, iy, seed), u - 1, v);
  const double c = gradient(hashLattice(ix, iy + 1, seed), u, v - 1),
               d = gradient(hashLattice(ix + 1, iy + 1, seed), u - 1, v - 1);
  const double s = noise_detail::fade(u), t = noise_detail::fade(v);
  const double low = a + s * (b - a), high = c + s * (d - c);
  return low + t * (high - low);
}

struct Octaves {
  int count = 5;
  double gain = 0.5;  // amplitude of each octave relative to the one before
};

inline double fractalNoise(double x, double y, uint32_t seed, Octaves octaves) {
  double sum = 0, amplitude = 1;
  for (int i = 0; i < octaves.count; ++i) {
    sum += amplitude * noise(x, y, seed + static_cast<uint32_t>(i));
    amplitude *= octaves.gain;
    x = 2 * x + 17.13;  // so that the lattices of the octaves do not line up
    y = 2 * y - 9.71;
  }
  return sum;
}

}  // namespace foreland::terrain
