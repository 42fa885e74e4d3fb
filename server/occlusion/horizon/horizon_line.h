// The inner loops of a horizon (horizon.h): what one line of heights hides in a range of bins. The same results with
// and without vector instructions. Pure.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>

#include "base/vectors.h"
#ifdef FORELAND_AVX2
#include <immintrin.h>
#endif

namespace foreland::server {

class HorizonLine {
 public:
  static constexpr int kBins = 64, kMaxHalo = 64;
  static constexpr float kNone = -1e30f;  // where there is no terrain
  static constexpr float kMaxStep = 1;    // vertices from one border of bins to the next

  // Heights of vertices at 0, 1, ..., in steps of any size; eight more may be read beyond them.
  struct Vertices {
    const uint16_t* heights;
    int count;
  };

  // Asks for the heights that findLeast() will read.
  static void prefetch(const Vertices& vertices, float first, float step, int count) {
    constexpr int kHeightsOfCacheLine = 32;
    const auto vertexAt = [&](float at) {
      return static_cast<int>(std::min(std::max(at, 0.0f), static_cast<float>(vertices.count - 1)));
    };
    const int last = vertexAt(first + static_cast<float>(count) * step) + 8;
    for (int v = vertexAt(first); v < last; v += kHeightsOfCacheLine) __builtin_prefetch(vertices.heights + v);
    __builtin_prefetch(vertices.heights + last);
  }
  explicit HorizonLine(Vectors vectors = widestVectors()) : vectors_(vectors) {}

  // The least height in each bin: bin k reaches from the vertex position first + k * step to the next one's. `count`
  // bins, at most kBins + kMaxHalo.
  void findLeast(const Vertices& vertices, float first, float step, int count) {
    sample(vertices, first, step, count + 1);
    runLoop<Vectors::kAvx2>(vectors_, static_cast<size_t>(count),
                            FindLeast{height_.data(), left_.data(), cell_.data(), least_.data()});
  }
  // Then of each bin k < kBins and the `halo` bins after it.
  void widen(int halo) {
    int width = 1;
    for (; 2 * width <= halo + 1; width *= 2) lower(width, kBins + halo - 2 * width + 1);
    if (width < halo + 1) lower(halo + 1 - width, kBins);
  }
  // Then raises the slopes of bins to those of the heights over the eye's, all in steps, times `per_rise` or
  // `per_drop`.
  void raise(float eye, float per_rise, float per_drop, std::array<float, kBins>& slopes) const {
    runLoop<Vectors::kAvx2>(vectors_, kBins, Raise{least_.data(), eye, per_rise, per_drop, slopes.data()});
  }

  // Multiples of 1 / scale, rounded down; the largest and the least if there is none so large or small.
  static void round(const std::array<float, kBins>& slopes, float scale, int16_t* rounded,
                    Vectors vectors = widestVectors()) {
#ifdef FORELAND_AVX2
    if (vectors >= Vectors::kAvx2) return roundByAvx2(slopes.data(), scale, rounded);
#endif
    static_cast<void>(vectors);
    for (int k = 0; k < kBins; ++k)
      rounded[k] = static_cast<int16_t>(std::max(std::min(std::floor(slopes[k] * scale), 32767.0f), -32768.0f));
  }

 private:
  static constexpr int kSize = kBins + kMaxHalo + 16;

  struct FindLeast {
    const float *height, *left;
    const int32_t* cell;
    float* least;
    [[gnu::always_inline]] void operator()(size_t begin, size_t end) const {
      const FindLeast f = *this;
      for (size_t k = begin; k < end; ++k) {
        const float lower = std::min(f.height[k], f.height[k + 1]);
        f.least[k] = f.cell[k] != f.cell[k + 1] ? std::min(lower, f.left[k + 1]) : lower;
      }
    }
  };
  struct Lower {
    float* least;
    size_t by;
    [[gnu::always_inline]] void operator()(size_t begin, size_t end) const {
      float* const to = least;
      const size_t from = by;
      for (size_t k = begin; k < end; ++k) to[k] = std::min(to[k], to[k + from]);
    }
  };
  struct Raise {
    const float* least;
    float eye, per_rise, per_drop;
    float* slopes;
    [[gnu::always_inline]] void operator()(size_t begin, size_t end) const {
      const Raise r = *this;
      for (size_t k = begin; k < end; ++k) {
        const float rise = r.least[k] - r.eye;
        r.slopes[k] = std::max(r.slopes[k], rise * (rise > 0 ? r.per_rise : r.per_drop));
      }
    }
  };

  void lower(int by, int count) {
    runLoop<Vectors::kAvx2>(vectors_, static_cast<size_t>(count), Lower{least_.data(), static_cast<size_t>(by)});
  }

  // At the borders of bins: heights, the vertices before them and these vertices' heights. A border beyond the last
  // vertex or before the first has none.
  void sample(const Vertices& vertices, float first, float step, int count) {
#ifdef FORELAND_AVX2
    if (vectors_ >= Vectors::kAvx2) return sampleByAvx2(vertices, first, step, count);
#endif
    const float most = static_cast<float>(vertices.count - 1);
    const int last_cell = vertices.count - 2;
    for (int k = 0; k < count; ++k) {
      const float at = first + static_cast<float>(k) * step, inside = std::min(std::max(at, 0.0f), most);
      const int cell = std::min(static_cast<int>(inside), last_cell);
      const auto left = static_cast<float>(vertices.heights[cell]),
                 right = static_cast<float>(vertices.heights[cell + 1]);
      height_[k] = inside == at ? left + (inside - static_cast<float>(cell)) * (right - left) : kNone;
      left_[k] = left;
      cell_[k] = cell;
    }
  }

#ifdef FORELAND_AVX2
  FORELAND_AVX2 static void roundByAvx2(const float* slopes, float scale, int16_t* rounded) {
    const __m256 most = _mm256_set1_ps(32767), least = _mm256_set1_ps(-32768), factor = _mm256_set1_ps(scale);
    for (int k = 0; k < kBins; k += 16) {
      __m256i eight[2];
      for (int i = 0; i < 2; ++i) {
        const __m256 scaled = _mm256_floor_ps(_mm256_mul_ps(_mm256_loadu_ps(slopes + k + 8 * i), factor));
        eight[i] = _mm256_cvttps_epi32(_mm256_max_ps(_mm256_min_ps(scaled, most), least));
      }
      // Packs within halves of 128 bits.
      const __m256i packed = _mm256_permute4x64_epi64(_mm256_packs_epi32(eight[0], eight[1]), 0xd8);
      _mm256_storeu_si256(reinterpret_cast<__m256i*>(rounded + k), packed);
    }
  }
  FORELAND_AVX2 void sampleByAvx2(const Vertices& vertices, float first, float step, int count) {
    const float most = static_cast<float>(vertices.count - 1);
    const int last_cell = vertices.count - 2;
    const __m256 lanes = _mm256_setr_ps(0, 1, 2, 3, 4, 5, 6, 7);
    for (int k = 0; k < count; k += 8) {
      const __m256 number = _mm256_add_ps(_mm256_set1_ps(static_cast<float>(k)), lanes),
                   at = _mm256_add_ps(_mm256_set1_ps(first), _mm256_mul_ps(number, _mm256_set1_ps(step))),
                   inside = _mm256_min_ps(_mm256_max_ps(at, _mm256_setzero_ps()), _mm256_set1_ps(most));
      const __m256i cell = _mm256_min_epi32(_mm256_cvttps_epi32(inside), _mm256_set1_epi32(last_cell));
      const int begin = _mm256_extract_epi32(cell, 0);
      const __m256i lane = _mm256_sub_epi32(cell, _mm256_set1_epi32(begin));
      __m256 ends[2];  // heights on the left and on the right
      for (int i = 0; i < 2; ++i) {
        const __m128i read = _mm_loadu_si128(reinterpret_cast<const __m128i*>(vertices.heights + begin + i));
        ends[i] = _mm256_cvtepi32_ps(_mm256_permutevar8x32_epi32(_mm256_cvtepu16_epi32(read), lane));
      }
      const __m256 share = _mm256_sub_ps(inside, _mm256_cvtepi32_ps(cell));
      const __m256 height = _mm256_add_ps(ends[0], _mm256_mul_ps(share, _mm256_sub_ps(ends[1], ends[0])));
      _mm256_storeu_ps(&height_[k],
                       _mm256_blendv_ps(_mm256_set1_ps(kNone), height, _mm256_cmp_ps(inside, at, _CMP_EQ_OQ)));
      _mm256_storeu_ps(&left_[k], ends[0]);
      _mm256_storeu_si256(reinterpret_cast<__m256i*>(&cell_[k]), cell);
    }
  }
#endif

  Vectors vectors_;
  std::array<float, kSize> height_, left_, least_;
  std::array<int32_t, kSize> cell_;
};

}  // namespace foreland::server
