// Imagery of globes: what imagery.h does of other scenes, face by face, and as finely as pictures are where they are.
// Texels fill the faces, so that those of one begin where those of another end, and gutters repeat these: a place on an
// edge has the same colour on both faces, and in a corner on all three.
#pragma once

#include <cstdint>
#include <filesystem>

#include "base/result.h"
#include "terrain/globe_picture.h"
#include "terrain/imagery/cube_fold.h"
#include "terrain/imagery/imagery.h"
#include "terrain/imagery/tile_image.h"

namespace foreland::terrain {

// A globe's texels where no finer tile tells them. Immutable; any thread.
class GlobeImagerySource {
 public:
  using Texel = LinearTexel;

  GlobeImagerySource(const GlobePicture& picture, const proto::TileLayer& layer) : picture_(picture), layer_(layer) {}

  // What the picture shows over a texel.
  LinearTexel at(uint32_t level, uint32_t face, uint32_t x, uint32_t y) const;
  LinearTexel meanOf(const LinearTexel& a, const LinearTexel& b, const LinearTexel& c, const LinearTexel& d) const {
    return terrain::meanOf(a, b, c, d);
  }
  template <class ReadTexel>
  LinearTexel beyond(uint32_t level, const FaceTexel& t, const ReadTexel& readTexel) const {
    const int64_t side = layer_.widthAt(level);
    if (t.beyond(side) < 2) return readTexel(foldedOver(t, side));
    const auto inner = [&](int64_t i) { return std::clamp<int64_t>(i, 0, side - 1); };
    const auto edge = [&](int64_t i) { return std::clamp<int64_t>(i, -1, side); };
    return meanOfThree(readTexel(FaceTexel{t.face, inner(t.x), inner(t.y)}),
                       readTexel(foldedOver(FaceTexel{t.face, edge(t.x), inner(t.y)}, side)),
                       readTexel(foldedOver(FaceTexel{t.face, inner(t.x), edge(t.y)}, side)));
  }

 private:
  static LinearTexel meanOfThree(const LinearTexel& a, const LinearTexel& b, const LinearTexel& c);

  const GlobePicture& picture_;
  const proto::TileLayer& layer_;
};

// The finest texels are no coarser than the finest picture's pixels, by more than 1 %, in the middle of a face.
proto::TileLayer globeImageryLayer(const GlobePicture& picture, uint32_t face_steps);

// Adds the tiles to `section` as a layer: those that are finer than their parents where a picture is. `boundsOf` is
// asked of boxes on one face.
Result<ImageryReport> addGlobeImagery(const GlobePicture& picture, uint32_t face_steps, const BoundsOf& boundsOf,
                                      const ImageryOptions& options, const KeepGoing& keepGoing, TileSection& section);

}  // namespace foreland::terrain
