#include "proto/refine/sweep.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <limits>

#if defined(__AVX2__)
#include <immintrin.h>
#elif defined(__wasm_simd128__)
#include <wasm_simd128.h>
#endif

#include "proto/refine/metric/node_positions.h"

namespace foreland::proto {

namespace {

constexpr uint32_t kLanes = EntryPool::kVector;
constexpr int32_t kHighest = 1 << 23;     // quanta: differences of two heights are exact floats
constexpr double kUnit = 0x1p-24;         // what rounding to a float is off by, at most, as a share
constexpr double kMore = 1.01;            // for products of roundings, and for the tolerance's own
constexpr int32_t kMiddle = 16;           // half cells from a tile's corner to its middle
constexpr double kLeast_m = 1e-6;         // what double precision is off by, and more
constexpr float kLargestError_m = 1e30f;  // a larger one passes like this one

// The signs of all lanes, the first lowest.
uint32_t signsOf(const int32_t* lanes) {
#if defined(__AVX2__)
  static_assert(kLanes == 8);
  return static_cast<uint32_t>(
      _mm256_movemask_ps(_mm256_castsi256_ps(_mm256_load_si256(reinterpret_cast<const __m256i*>(lanes)))));
#elif defined(__wasm_simd128__)
  static_assert(kLanes == 8);
  return static_cast<uint32_t>(wasm_i32x4_bitmask(wasm_v128_load(lanes)) | wasm_i32x4_bitmask(wasm_v128_load(lanes + 4))
                                                                               << 4);
#else
  uint32_t signs = 0;
  for (uint32_t i = 0; i < kLanes; ++i) signs |= (lanes[i] < 0 ? 1u : 0u) << i;
  return signs;
#endif
}

}  // namespace

Sweep::Sweep(const TerrainDomain& domain, const Metric& metric, HiddenEntries hidden, double tolerance)
    : domain_(domain), hidden_(hidden), region_radius_(metric.regionRadius()), tolerance_(tolerance) {
  const Frame& frame = domain.frame.transform().frame();
  const Frustum& frustum = metric.frustum();
  row_ = PlanarPositions(domain, metric).rows();
  quantum_ = frame.height_quantum_m;
  step_x_ = glm::length(frame.axis_x_m);
  step_y_ = glm::length(frame.axis_y_m);
  const double eye_height = std::clamp(std::round(metric.eye().z / quantum_), double{-kHighest}, double{kHighest});
  for (std::array<double, 4>& row : row_) row[3] += row[2] * eye_height;
  const auto f = [](double value) { return static_cast<float>(value); };
  const Frustum::Sides sides = frustum.sides();
  k_ = {.up = {f(row_[0][2]), f(row_[1][2]), f(row_[2][2])},
        .eye_height = f(eye_height),
        .cos_angle = f(frustum.cosAngle()),
        .sin_angle = f(frustum.sinAngle()),
        .cos_corner = f(frustum.cosCorner()),
        .inverse_cos_corner = f(frustum.inverseCosCorner()),
        .sin_x = f(sides.sin_x),
        .cos_x = f(sides.cos_x),
        .sin_y = f(sides.sin_y),
        .cos_y = f(sides.cos_y),
        .focal_over_tau = f(metric.focalOverTau()),
        .any_direction = metric.hasVerticalErrors() ? 0 : std::numeric_limits<float>::infinity(),
        .of_distance = f(tolerance * kMore * 21 * kUnit),
        .of_error = f(tolerance * kMore * 5 * kUnit * frustum.inverseCosCorner()),
        .of_side = f(tolerance * kMore * 27 * kUnit * frustum.sinAngle()),
        .of_steep = f(tolerance * kMore * 0.25 * frustum.sinAngle())};
}

Sweep::Place Sweep::placeOf(int level, Slot first_slot, QuantisedRadius page_radius) const {
  const auto half =
      static_cast<double>(1u << (domain_.grid.shape().root_log2 - 1 - (static_cast<uint32_t>(level) >> 1)));
  const NodeId first = domain_.grid.pageNodes(level, first_slot).at(0);  // of centres the middle of the first cell
  const bool is_sides = (level & 1) != 0;
  const double right = kMiddle * half, up = (is_sides ? kMiddle / 2 : kMiddle) * half;  // from a corner to the middle
  const double x = first.x() - half + right, y = first.y() - (is_sides ? 0 : half) + up;
  Place place;
  for (size_t i = 0; i < kRows; ++i) {
    place.origin[i] = static_cast<float>(row_[i][0] * x + row_[i][1] * y + row_[i][3]);
    place.along_x[i] = static_cast<float>(row_[i][0] * half);
    place.along_y[i] = static_cast<float>(row_[i][1] * half);
  }
  const double radius = domain_.radius(level, page_radius) + region_radius_;
  const double extent = 2 * (right * step_x_ + up * step_y_);
  place.radius = static_cast<float>(radius);
  place.tolerance =
      static_cast<float>(tolerance_ * kMore * (kUnit * (4.5 * extent + 7 * quantum_ + 6 * radius) + kLeast_m));
  return place;
}

Sweep::Found Sweep::test(int level, Slot first, const EntryBlock& block, const uint32_t* bits,
                         const uint8_t* heights) const {
  const Place place = placeOf(level, first, block.radius);
  return (level & 1) != 0 ? testAll<true>(place, bits, heights, block.count)
                          : testAll<false>(place, bits, heights, block.count);
}

// The terms are the metric's, in its order. A loop over the lanes of a vector, which the compiler makes instructions
// of.
template <bool kSides>
Sweep::Found Sweep::testAll(const Place& at, const uint32_t* entries, const uint8_t* heights, uint32_t count) const {
  const auto k = k_;  // its own memory, so that the loop vectorises
  const Place place = at;
  Found found;
  for (uint32_t begin = 0; begin < count; begin += kLanes) {
    alignas(32) int32_t passes[kLanes], fails[kLanes], is_in_section[kLanes], is_no_height[kLanes], is_odd[kLanes];
    // Its own memory, and all of one width, so that the loop vectorises.
    alignas(32) int32_t entry[kLanes], height[kLanes];
    for (uint32_t i = 0; i < kLanes; ++i) entry[i] = static_cast<int32_t>(entries[begin + i]);
    for (uint32_t i = 0; i < kLanes; ++i) height[i] = FrontierEntry::heightOf(entries[begin + i], heights[begin + i]);
    for (uint32_t i = 0; i < kLanes; ++i) {
      const int32_t bits = entry[i];
      const int32_t cell = kSides ? bits >> 1 & 127 : bits & 255, along_y = kSides ? bits & 1 : 1;
      const auto lattice_x = static_cast<float>(2 * (cell & 15) + (kSides ? 1 - along_y : 1) - kMiddle),
                 lattice_y = static_cast<float>(2 * (cell >> 4) + along_y - (kSides ? kMiddle / 2 : kMiddle));
      const auto row = [&](size_t r) {
        return place.origin[r] + place.along_x[r] * lattice_x + place.along_y[r] * lattice_y;
      };
      const float h = static_cast<float>(height[i]) - k.eye_height;
      const float x = row(0) + k.up[0] * h, y = row(1) + k.up[1] * h, z = row(2) + k.up[2] * h;
      const float east = row(3), north = row(4), R = place.radius;

      const float rho2 = x * x + y * y, d2 = rho2 + z * z, d = std::sqrt(d2), rho = std::sqrt(rho2);
      const float horizontal = std::sqrt(east * east + north * north);
      const float by_axis = z * k.cos_angle - rho * k.sin_angle - R, by_corner = (d - R) * k.cos_corner;
      const float nearest = std::max(std::max(by_axis, by_corner), static_cast<float>(Metric::kNearest_m));
      const int32_t bound = bits >> 8 & 255;
      const float error = bound > 0 ? QuantisedError::metresFast(bound) : 0.0f;
      const float K = std::min(error * k.focal_over_tau, kLargestError_m);
      const float side = std::min(z * k.sin_x - std::fabs(x) * k.cos_x, z * k.sin_y - std::fabs(y) * k.cos_y);
      const float beside2 = std::max(0.0f, d2 - side * side);

      const float any = K * k.inverse_cos_corner - nearest,
                  vertical = K * (horizontal + R + k.any_direction) - nearest * nearest,
                  inside = side * k.cos_angle + std::sqrt(beside2) * k.sin_angle + R;
      const float tolerance = k.of_distance * d + place.tolerance;
      const float of_any = tolerance + k.of_error * K, of_vertical = tolerance * (K + 2 * nearest + tolerance),
                  of_inside = tolerance + (beside2 * 16 < d2 ? k.of_side + k.of_steep : k.of_side) * d;
      passes[i] = -static_cast<int32_t>((any > of_any) & (vertical > of_vertical) & (inside > of_inside));
      fails[i] = -static_cast<int32_t>((any < -of_any) | (vertical < -of_vertical) | (inside < -of_inside));
      is_in_section[i] = bits << 15;
      is_no_height[i] = height[i] - FrontierEntry::kLeastHeight;
      is_odd[i] = bits << 14;
    }
    static_assert((FrontierEntry::kHidden & 1) == 1 && (FrontierEntry::kUnknown & 1) == 0);
    const uint32_t none = signsOf(is_no_height), hidden = none & signsOf(is_odd);
    const uint32_t in = signsOf(is_in_section), pass = signsOf(passes) & ~none, fail = signsOf(fails) & ~none;
    const uint32_t changed = (in & fail) | (~in & pass), same = (in & pass) | (~in & fail);
    const uint32_t unsure = ~(changed | same) & (hidden_ == HiddenEntries::kLeave ? ~hidden : ~0u) & 0xffu;
    found.changed.words[begin / 64] |= uint64_t{changed} << begin % 64;
    found.unsure.words[begin / 64] |= uint64_t{unsure} << begin % 64;
  }
  const SlotBits there = SlotBits::below(count);
  return {found.changed & there, found.unsure & there};
}

}  // namespace foreland::proto
