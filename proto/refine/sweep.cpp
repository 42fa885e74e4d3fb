#include "proto/refine/sweep.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <limits>

#if defined(__SSE2__)
#include <immintrin.h>
#elif defined(__wasm_simd128__)
#include <wasm_simd128.h>
#endif

#include "proto/refine/metric/node_positions.h"

namespace foreland::proto {

namespace {

constexpr int32_t kHighest = 1 << 23;     // quanta: differences of two heights are exact floats
constexpr double kUnit = 0x1p-24;         // what rounding to a float is off by, at most, as a share
constexpr double kMore = 1.01;            // for products of roundings, and for the tolerance's own
constexpr int32_t kMiddle = 16;           // half cells from a tile's corner to its middle
constexpr double kLeast_m = 1e-6;         // what double precision is off by, and more
constexpr float kLargestError_m = 1e30f;  // a larger one passes like this one

// What the loop says of an entry.
constexpr int32_t kChanged = -128, kUnsure = 64;  // else 0
using Answers = std::array<int32_t, kPageSlots>;

// Of which entries the answer is kChanged, and kUnsure: of so many, in whole vectors of kTogether.
#if defined(__SSE2__)
constexpr uint32_t kTogether = 16;
Sweep::Found collect(const Answers& answers, uint32_t count) {
  Sweep::Found found;
  for (uint32_t i = 0; i < count; i += kTogether) {
    const auto four = [&](uint32_t k) { return _mm_load_si128(reinterpret_cast<const __m128i*>(&answers[i + 4 * k])); };
    const __m128i bytes = _mm_packs_epi16(_mm_packs_epi32(four(0), four(1)), _mm_packs_epi32(four(2), four(3)));
    found.changed.words[i / 64] |= static_cast<uint64_t>(_mm_movemask_epi8(bytes)) << i % 64;
    found.unsure.words[i / 64] |= static_cast<uint64_t>(_mm_movemask_epi8(_mm_add_epi8(bytes, bytes))) << i % 64;
  }
  return found;
}
#if defined(FORELAND_AVX2)
FORELAND_AVX2 Sweep::Found collectByAvx2(const Answers& answers, uint32_t count) {
  Sweep::Found found;
  const __m256i order = _mm256_setr_epi32(0, 4, 1, 5, 2, 6, 3, 7);  // packs work within halves
  for (uint32_t i = 0; i < count; i += 2 * kTogether) {
    const __m256i* const eight = reinterpret_cast<const __m256i*>(&answers[i]);
    const __m256i packed =
        _mm256_packs_epi16(_mm256_packs_epi32(_mm256_load_si256(eight), _mm256_load_si256(eight + 1)),
                           _mm256_packs_epi32(_mm256_load_si256(eight + 2), _mm256_load_si256(eight + 3)));
    const __m256i bytes = _mm256_permutevar8x32_epi32(packed, order);
    const auto changed = static_cast<uint32_t>(_mm256_movemask_epi8(bytes)),
               unsure = static_cast<uint32_t>(_mm256_movemask_epi8(_mm256_add_epi8(bytes, bytes)));
    found.changed.words[i / 64] |= uint64_t{changed} << i % 64;
    found.unsure.words[i / 64] |= uint64_t{unsure} << i % 64;
  }
  return found;
}
#endif
#elif defined(__wasm_simd128__)
constexpr uint32_t kTogether = 4;
Sweep::Found collect(const Answers& answers, uint32_t count) {
  Sweep::Found found;
  for (uint32_t i = 0; i < count; i += kTogether) {
    const v128_t four = wasm_v128_load(&answers[i]);
    found.changed.words[i / 64] |= static_cast<uint64_t>(wasm_i32x4_bitmask(four)) << i % 64;
    found.unsure.words[i / 64] |= static_cast<uint64_t>(wasm_i32x4_bitmask(wasm_i32x4_shl(four, 25))) << i % 64;
  }
  return found;
}
#else
constexpr uint32_t kTogether = 1;
Sweep::Found collect(const Answers& answers, uint32_t count) {
  Sweep::Found found;
  for (uint32_t i = 0; i < count; ++i) {
    found.changed.add(static_cast<uint8_t>(i), answers[i] == kChanged);
    found.unsure.add(static_cast<uint8_t>(i), answers[i] == kUnsure);
  }
  return found;
}
#endif

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

[[gnu::always_inline]] inline Sweep::Place Sweep::placeOf(int level, Slot first_slot,
                                                          QuantisedRadius page_radius) const {
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

// The terms are the metric's, in its order.
template <bool kSides>
struct Sweep::Loop {
  const Constants& constants;
  const Place& at;
  const uint32_t* all_bits;
  const uint8_t* upper_heights;
  int32_t hidden_is_same;  // -1 or 0
  int32_t* answers;

  [[gnu::always_inline]] void operator()(size_t begin, size_t end) const {
    const Constants k = constants;  // their own memory, so that the loops vectorise
    const Place place = at;
    const uint32_t* const entry = all_bits;
    const uint8_t* const upper = upper_heights;
    const int32_t leave = hidden_is_same;
    int32_t* const answer = answers;
    // A loop of its own, so that all that the next one reads is of one width.
    alignas(64) std::array<int32_t, kPageSlots> height;
    for (size_t i = begin; i < end; ++i) height[i] = FrontierEntry::heightOf(entry[i], upper[i]);
    for (size_t i = begin; i < end; ++i) {
      const auto bits = static_cast<int32_t>(entry[i]);
      const int32_t cell = kSides ? bits >> 1 & 127 : bits & 255, along_y = kSides ? bits & 1 : 1;
      const auto lattice_x = static_cast<float>(2 * (cell & 15) + (kSides ? 1 - along_y : 1) - kMiddle),
                 lattice_y = static_cast<float>(2 * (cell >> 4) + along_y - (kSides ? kMiddle / 2 : kMiddle));
      const auto row = [&](size_t r) __attribute__((always_inline)) {
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
      const int32_t is_known = -static_cast<int32_t>(height[i] >= FrontierEntry::kLeastHeight);
      const int32_t is_hidden = -static_cast<int32_t>(height[i] == FrontierEntry::kHidden);
      const int32_t passes = -static_cast<int32_t>((any > of_any) & (vertical > of_vertical) & (inside > of_inside));
      const int32_t fails = -static_cast<int32_t>((any < -of_any) | (vertical < -of_vertical) | (inside < -of_inside));
      const int32_t is_in_section = bits << 15 >> 31;
      const int32_t changed = ((is_in_section & fails) | (~is_in_section & passes)) & is_known;
      const int32_t same = ((is_in_section & passes) | (~is_in_section & fails)) & is_known;
      answer[i] = (changed & kChanged) | (~changed & ~same & ~(is_hidden & leave) & kUnsure);
    }
  }
};

Sweep::Found Sweep::test(int level, Slot first, const EntryBlock& block, const uint32_t* bits, const uint8_t* heights,
                         Vectors vectors) const {
  const int32_t leave = hidden_ == HiddenEntries::kLeave ? -1 : 0;
  const uint32_t count = block.count;
  // In whole vectors, so that nothing is left for a loop without any.
  const uint32_t held = (count + EntryPool::kVector - 1) / EntryPool::kVector * EntryPool::kVector;
  alignas(64) Answers answers;
  runLoop<Vectors::kAvx2>(
      vectors, held, [&](size_t begin, size_t end) __attribute__((always_inline)) {
        const Place place = placeOf(level, first, block.radius);
        if ((level & 1) != 0)
          Loop<true>{k_, place, bits, heights, leave, answers.data()}(begin, end);
        else
          Loop<false>{k_, place, bits, heights, leave, answers.data()}(begin, end);
      });
#if defined(FORELAND_AVX2)
  const Found found = (vectors >= Vectors::kAvx2 ? collectByAvx2 : collect)(answers, count);
#else
  const Found found = collect(answers, count);
#endif
  const SlotBits there = SlotBits::below(count);
  return {found.changed & there, found.unsure & there};
}

}  // namespace foreland::proto
