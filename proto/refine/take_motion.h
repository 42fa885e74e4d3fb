// Takes a step's motion off the slacks of one page's frontier entries (frontier.h), and finds those that are used up.
// It touches every entry of the frontier in every step, so it has vector instructions; takeMotionByScalars() is what
// they must equal, bit for bit, and stands in for them elsewhere. Pure; any thread; portable.
#pragma once

#include <algorithm>
#include <bit>
#include <cstdint>

#if defined(__x86_64__)
#include <immintrin.h>
#elif defined(__wasm_simd128__)
#include <wasm_simd128.h>
#endif

#include "base/vectors.h"
#include "proto/refine/memory/entry_pool.h"
#include "proto/refine/memory/slot_bits.h"
#include "proto/refine/metric/motion_bound.h"

namespace foreland::proto {

// Columns as EntryPool has them. Whole vectors are worked on, up to `count` rounded up to EntryPool::kVector. Which
// entries have a slack below zero then, by their index; what it says of those from `count` on means nothing.
inline SlotBits takeMotionByScalars(const MotionBound& motion, uint32_t* slacks, const uint32_t* bits, uint32_t count) {
  SlotBits stale;
  for (uint32_t i = 0; i < count; ++i) {
    const uint32_t sensitivity = FrontierEntry::sensitivityOf(bits[i]);
    const float slack =
        std::bit_cast<float>(slacks[i]) -
        (motion.fixed[sensitivity] + motion.per_distance[sensitivity] * FrontierEntry::maxDistanceOf(bits[i]));
    slacks[i] = std::bit_cast<uint32_t>(slack);
    stale.add(static_cast<uint8_t>(i), slacks[i] >> 31 != 0);
  }
  return stale;
}

#if defined(FORELAND_AVX2)

FORELAND_AVX2 inline SlotBits takeMotionByAvx2(const MotionBound& motion, uint32_t* slacks, const uint32_t* bits,
                                               uint32_t count) {
  static_assert(EntryPool::kVector == 8);
  // Both tables have four numbers, which the lower two bits of a lane choose from: a sensitivity.
  const __m256 fixed = _mm256_broadcast_ps(reinterpret_cast<const __m128*>(motion.fixed.data())),
               per_distance = _mm256_broadcast_ps(reinterpret_cast<const __m128*>(motion.per_distance.data()));
  const __m256i distance_bits = _mm256_set1_epi32(static_cast<int32_t>(0xfffc0000u));
  SlotBits stale;
  for (uint32_t i = 0; i < count; i += EntryPool::kVector) {
    const __m256i entry = _mm256_loadu_si256(reinterpret_cast<const __m256i*>(bits + i));
    const __m256i sensitivity = _mm256_srli_epi32(entry, 16);
    const __m256 max_distance = _mm256_castsi256_ps(_mm256_srli_epi32(_mm256_and_si256(entry, distance_bits), 1));
    const __m256 taken = _mm256_add_ps(_mm256_permutevar_ps(fixed, sensitivity),
                                       _mm256_mul_ps(_mm256_permutevar_ps(per_distance, sensitivity), max_distance));
    float* const slack = reinterpret_cast<float*>(slacks + i);  // the instructions may read and write any type
    const __m256 left = _mm256_sub_ps(_mm256_loadu_ps(slack), taken);
    _mm256_storeu_ps(slack, left);
    stale.words[i / 64] |= static_cast<uint64_t>(_mm256_movemask_ps(left)) << i % 64;
  }
  return stale;
}

inline SlotBits takeMotion(const MotionBound& motion, uint32_t* slacks, const uint32_t* bits, uint32_t count,
                           Vectors vectors = widestVectors()) {
  return vectors >= Vectors::kAvx2 ? takeMotionByAvx2(motion, slacks, bits, count)
                                   : takeMotionByScalars(motion, slacks, bits, count);
}

#elif defined(__wasm_simd128__)

inline SlotBits takeMotion(const MotionBound& motion, uint32_t* slacks, const uint32_t* bits, uint32_t count,
                           Vectors vectors = widestVectors()) {
  if (vectors == Vectors::kScalar) return takeMotionByScalars(motion, slacks, bits, count);
  static_assert(EntryPool::kVector % 4 == 0);
  // The bytes of one of four numbers, chosen by a sensitivity.
  const v128_t fixed = wasm_v128_load(motion.fixed.data()), per_distance = wasm_v128_load(motion.per_distance.data());
  SlotBits stale;
  for (uint32_t i = 0; i < count; i += 4) {
    const v128_t entry = wasm_v128_load(bits + i);
    const v128_t sensitivity = wasm_v128_and(wasm_u32x4_shr(entry, 16), wasm_i32x4_splat(3));
    const v128_t bytes =
        wasm_i32x4_add(wasm_i32x4_mul(sensitivity, wasm_i32x4_splat(0x04040404)), wasm_i32x4_splat(0x03020100));
    const v128_t max_distance = wasm_i32x4_shl(wasm_u32x4_shr(entry, 18), 17);
    const v128_t taken = wasm_f32x4_add(wasm_i8x16_swizzle(fixed, bytes),
                                        wasm_f32x4_mul(wasm_i8x16_swizzle(per_distance, bytes), max_distance));
    const v128_t left = wasm_f32x4_sub(wasm_v128_load(slacks + i), taken);
    wasm_v128_store(slacks + i, left);
    stale.words[i / 64] |= static_cast<uint64_t>(wasm_i32x4_bitmask(left)) << i % 64;
  }
  return stale;
}

#else

inline SlotBits takeMotion(const MotionBound& motion, uint32_t* slacks, const uint32_t* bits, uint32_t count,
                           Vectors = widestVectors()) {
  return takeMotionByScalars(motion, slacks, bits, count);
}

#endif

}  // namespace foreland::proto
