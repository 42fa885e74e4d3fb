// Relief of globes: what sparse_ground.h does of other scenes that are fine in places only, face by face. Texels fill
// the faces, so that those of one begin where those of another end: a texel of the finest level is a square between
// samples, and its height the mean of the corners'. Gutters are read at the places beyond the side as the face's own
// coordinates go on, so that differences across it are slopes along these.
#pragma once

#include <cmath>
#include <cstdint>
#include <filesystem>

#include "base/result.h"
#include "proto/imagery/tile.h"
#include "terrain/imagery/cube_fold.h"
#include "terrain/imagery/sparse_ground.h"
#include "terrain/store/stored_heights.h"
#include "terrain/store/tables/tile_section.h"

namespace foreland::terrain {

// Steps as reliefLayer() has them.
proto::TileLayer globeReliefLayer(const proto::Frame& frame);

// Where readTexel, of texels within faces, has a value for a texel beyond the side of one: bilinear about its place.
template <class ReadTexel>
double reliefBeyond(const FaceTexel& t, int64_t side, const ReadTexel& readTexel);

// As addSparseRelief(); `target` is the scene file, beside which temporary files are made.
Result<bool> addGlobeRelief(const StoredHeights& ground, const SparseGroundBounds& bounds, const proto::Frame& frame,
                            const std::filesystem::path& target, unsigned threads, const KeepGoing& keepGoing,
                            TileSection& section);

// The heights of a globe's texels where no finer tile tells them, in quanta. Immutable; any thread.
class GlobeReliefSource {
 public:
  using Texel = float;

  GlobeReliefSource(const StoredHeights& ground, const proto::TileLayer& layer) : ground_(ground), layer_(layer) {}

  float at(uint32_t level, uint32_t face, uint32_t x, uint32_t y) const;
  float meanOf(float a, float b, float c, float d) const { return static_cast<float>(0.25 * (double{a} + b + c + d)); }
  template <class ReadTexel>
  float beyond(uint32_t level, const FaceTexel& t, const ReadTexel& readTexel) const {
    return static_cast<float>(reliefBeyond(t, layer_.widthAt(level), readTexel));
  }

 private:
  const StoredHeights& ground_;
  const proto::TileLayer& layer_;
};

// The place of a texel beyond a side, in texels of the face that it is on.
FacePlace placeBeyond(const FaceTexel& t, int64_t side);

template <class ReadTexel>
double reliefBeyond(const FaceTexel& t, int64_t side, const ReadTexel& readTexel) {
  const FacePlace place = placeBeyond(t, side);
  const double px = place.x - 0.5, py = place.y - 0.5;
  const auto x = static_cast<int64_t>(std::floor(px)), y = static_cast<int64_t>(std::floor(py));
  const double u = px - static_cast<double>(x), v = py - static_cast<double>(y);
  const auto read = [&](int64_t i, int64_t j) {
    FaceTexel at{place.face, i, j};
    if (at.beyond(side) == 2) at.y = std::clamp<int64_t>(j, 0, side - 1);  // at one of the eight corners
    return double{readTexel(foldedOver(at, side))};
  };
  return (read(x, y) * (1 - u) + read(x + 1, y) * u) * (1 - v) +
         (read(x, y + 1) * (1 - u) + read(x + 1, y + 1) * u) * v;
}

}  // namespace foreland::terrain
