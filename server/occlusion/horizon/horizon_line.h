// The inner loops of a horizon (horizon.h): what one line of heights hides in a range of bins. The same results with
// and without vector instructions. Pure.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>

#ifdef __AVX2__
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
  // The least height in each bin: bin k reaches from the vertex position first + k * step to the next one's. `count`
  // bins, at most kBins + kMaxHalo.
  void findLeast(const Vertices& vertices, float first, float step, int count) {
    sample(vertices, first, step, count + 1);
    for (int k = 0; k < count; ++k) {
      const float least = std::min(height_[k], height_[k + 1]);
      least_[k] = cell_[k] != cell_[k + 1] ? std::min(least, left_[k + 1]) : least;
    }
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
    for (int k = 0; k < kBins; ++k) {
      const float rise = least_[k] - eye;
      slopes[k] = std::max(slopes[k], rise * (rise > 0 ? per_rise : per_drop));
    }
  }

  // Multiples of 1 / scale, rounded down; the largest and the least if there is none so large or small.
  static void round(const std::array<float, kBins>& slopes, float scale, int16_t* rounded) {
#ifdef __AVX2__
    const __m256 most = _mm256_set1_ps(32767), least = _mm256_set1_ps(-32768), factor = _mm256_set1_ps(scale);
    const auto eight = [&](int k) {
      const __m256 scaled = _mm256_floor_ps(_mm256_mul_ps(_mm256_loadu_ps(&slopes[k]), factor));
      return _mm256_cvttps_epi32(_mm256_max_ps(_mm256_min_ps(scaled, most), least));
    };
    for (int k = 0; k < kBins; k += 16) {
      // Packs within halves of 128 bits.
      const __m256i packed = _mm256_permute4x64_epi64(_mm256_packs_epi32(eight(k), eight(k + 8)), 0xd8);
      _mm256_storeu_si256(reinterpret_cast<__m256i*>(rounded + k), packed);
    }
#else
    for (int k = 0; k < kBins; ++k)
      rounded[k] = static_cast<int16_t>(std::max(std::min(std::floor(slopes[k] * scale), 32767.0f), -32768.0f));
#endif
  }

 private:
  static constexpr int kSize = kBins + kMaxHalo + 16;

  void lower(int by, int count) {
    for (int k = 0; k < count; ++k) least_[k] = std::min(least_[k], least_[k + by]);
  }

  // At the borders of bins: heights, the vertices before them and these vertices' heights. A border beyond the last
  // vertex or before the first has none.
  void sample(const Vertices& vertices, float first, float step, int count) {
    const float most = static_cast<float>(vertices.count - 1);
    const int last_cell = vertices.count - 2;
#ifdef __AVX2__
    const __m256 lanes = _mm256_setr_ps(0, 1, 2, 3, 4, 5, 6, 7);
    for (int k = 0; k < count; k += 8) {
      const __m256 number = _mm256_add_ps(_mm256_set1_ps(static_cast<float>(k)), lanes),
                   at = _mm256_add_ps(_mm256_set1_ps(first), _mm256_mul_ps(number, _mm256_set1_ps(step))),
                   inside = _mm256_min_ps(_mm256_max_ps(at, _mm256_setzero_ps()), _mm256_set1_ps(most));
      const __m256i cell = _mm256_min_epi32(_mm256_cvttps_epi32(inside), _mm256_set1_epi32(last_cell));
      const int begin = _mm256_extract_epi32(cell, 0);
      const __m256i lane = _mm256_sub_epi32(cell, _mm256_set1_epi32(begin));
      const auto eightFrom = [&](int vertex) {
        const __m128i read = _mm_loadu_si128(reinterpret_cast<const __m128i*>(vertices.heights + vertex));
        return _mm256_cvtepi32_ps(_mm256_permutevar8x32_epi32(_mm256_cvtepu16_epi32(read), lane));
      };
      const __m256 left = eightFrom(begin), right = eightFrom(begin + 1);
      const __m256 share = _mm256_sub_ps(inside, _mm256_cvtepi32_ps(cell));
      const __m256 height = _mm256_add_ps(left, _mm256_mul_ps(share, _mm256_sub_ps(right, left)));
      _mm256_storeu_ps(&height_[k],
                       _mm256_blendv_ps(_mm256_set1_ps(kNone), height, _mm256_cmp_ps(inside, at, _CMP_EQ_OQ)));
      _mm256_storeu_ps(&left_[k], left);
      _mm256_storeu_si256(reinterpret_cast<__m256i*>(&cell_[k]), cell);
    }
#else
    for (int k = 0; k < count; ++k) {
      const float at = first + static_cast<float>(k) * step, inside = std::min(std::max(at, 0.0f), most);
      const int cell = std::min(static_cast<int>(inside), last_cell);
      const auto left = static_cast<float>(vertices.heights[cell]),
                 right = static_cast<float>(vertices.heights[cell + 1]);
      height_[k] = inside == at ? left + (inside - static_cast<float>(cell)) * (right - left) : kNone;
      left_[k] = left;
      cell_[k] = cell;
    }
#endif
  }

  std::array<float, kSize> height_, left_, least_;
  std::array<int32_t, kSize> cell_;
};

}  // namespace foreland::server
