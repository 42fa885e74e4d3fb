// Vector instructions, chosen at run time. A program runs on every processor of its kind; the few loops that take most
// of the time are compiled for wider vectors besides, and runLoop() takes what the processor has. A loop is plain
// arithmetic in a fixed order, so all of these give the same bits. Pure; any thread.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

namespace foreland {

enum class Vectors : uint8_t {
  kScalar,  // one after another: what the others must equal
  kBuilt,   // those that the program is built for: SSE2, NEON or simd128 unless it was told otherwise
  kAvx2,
  kAvx512,
};
inline constexpr std::array kAllVectors{Vectors::kScalar, Vectors::kBuilt, Vectors::kAvx2, Vectors::kAvx512};

// What is compiled for each; empty where there is no such version. None has fused operations: AVX-512 has some of its
// own, but g++ makes none of these loops. clang, which only judges what g++ builds, is not told of it.
#if defined(__x86_64__)
#define FORELAND_AVX2 [[gnu::target("avx2")]]
#if !defined(__clang__)
#define FORELAND_AVX512 [[gnu::target("avx512f,avx512dq,avx512bw,avx512vl,prefer-vector-width=512")]]
#endif
#endif

namespace vectors_detail {

inline Vectors findWidest() {
#if defined(FORELAND_AVX512)
  if (__builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512dq") && __builtin_cpu_supports("avx512bw") &&
      __builtin_cpu_supports("avx512vl"))
    return Vectors::kAvx512;
#endif
#if defined(FORELAND_AVX2)
  if (__builtin_cpu_supports("avx2")) return Vectors::kAvx2;
#endif
  return Vectors::kBuilt;
}
inline const Vectors widest = findWidest();

// The loop must be inlined into each of these, which are not inlined themselves, to have its instructions.
template <class Loop>
[[gnu::noinline]] void runBuilt(const Loop& loop, size_t begin, size_t end) {
  loop(begin, end);
}
#if defined(FORELAND_AVX2)
template <class Loop>
FORELAND_AVX2 [[gnu::noinline]] void runAvx2(const Loop& loop, size_t begin, size_t end) {
  loop(begin, end);
}
#endif
#if defined(FORELAND_AVX512)
template <class Loop>
FORELAND_AVX512 [[gnu::noinline]] void runAvx512(const Loop& loop, size_t begin, size_t end) {
  loop(begin, end);
}
#endif

}  // namespace vectors_detail

// The widest of this processor that programs have.
inline Vectors widestVectors() { return vectors_detail::widest; }

// Calls loop(begin, end), which does what it does to each i, begin <= i < end, and is [[gnu::always_inline]], for all
// of `count`. `vectors` are at most the widest that the processor has, `kMost` the widest that the loop is worth.
template <Vectors kMost, class Loop>
void runLoop(Vectors vectors, size_t count, const Loop& loop) {
#if defined(FORELAND_AVX512)
  if constexpr (kMost >= Vectors::kAvx512)
    if (vectors >= Vectors::kAvx512) return vectors_detail::runAvx512(loop, 0, count);
#endif
#if defined(FORELAND_AVX2)
  if (vectors >= Vectors::kAvx2) return vectors_detail::runAvx2(loop, 0, count);
#endif
  if (vectors >= Vectors::kBuilt) return vectors_detail::runBuilt(loop, 0, count);
  for (size_t i = 0; i < count; ++i) vectors_detail::runBuilt(loop, i, i + 1);
}

}  // namespace foreland
