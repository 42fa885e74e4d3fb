#include "terrain/remesh/importance.h"

#include <algorithm>
#include <cmath>

#include "terrain/compare/deviation.h"
#include "terrain/parallel.h"

namespace foreland::terrain {

namespace {

using glm::dvec3;

constexpr double kGain = 4;           // the vertex with the largest error gets 1 + kGain times its weight
constexpr int kSpreadRings = 3;       // rings of neighbours that also gain,
constexpr double kFalloff = 0.7;      // by this factor less in each ring
constexpr double kFoldPenalty = 0.1;  // of the largest distance, added for each folded triangle
constexpr uint64_t kSharesAtOnce = 256;

}  // namespace

Importance::Importance(const Original& original, unsigned threads)
    : original_(original),
      threads_(threads),
      surface_({original.positions, original.faces}),
      weights_(original.positions.size(), 1.0) {}

Importance::AttemptCost Importance::update(const std::vector<Triangle>& triangles, const std::vector<dvec3>& positions,
                                           const std::vector<SurfacePoint>& points) {
  const ClosestPoint attempt({positions, triangles});
  std::vector<double> shares(original_.positions.size());
  parallelFor((shares.size() + kSharesAtOnce - 1) / kSharesAtOnce, threads_,
              [&](uint64_t chunk, unsigned) {
                for (uint64_t v = chunk * kSharesAtOnce;
                     v < std::min<uint64_t>(shares.size(), (chunk + 1) * kSharesAtOnce); ++v)
                  shares[v] = attempt.find(original_.positions[v]).distance;
              },
              [](uint64_t) { return true; });
  const double largest = *std::max_element(shares.begin(), shares.end());
  for (double& share : shares) share = largest > 0 ? std::pow(share / largest, 2) : 0;

  const std::vector<uint32_t> folded = findFlipped({positions, triangles}, surface_, threads_);
  for (uint32_t f : folded)
    for (uint32_t v : triangles[f])
      for (uint32_t corner : original_.faces[points[v].face]) shares[corner] = 1;
  spread(shares);
  for (size_t v = 0; v < shares.size(); ++v) weights_[v] *= 1 + kGain * shares[v];
  return {!folded.empty(), largest * (1 + kFoldPenalty * static_cast<double>(folded.size()))};
}

void Importance::spread(std::vector<double>& shares) const {
  for (int step = 0; step < kSpreadRings; ++step) {
    const std::vector<double> before = shares;
    for (const Triangle& t : original_.faces)
      for (uint32_t to : t)
        for (uint32_t from : t) shares[to] = std::max(shares[to], kFalloff * before[from]);
  }
}

}  // namespace foreland::terrain
