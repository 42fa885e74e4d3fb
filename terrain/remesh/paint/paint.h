// Transfers the colours of a model to the base faces of its remesh, as one image for all
// (proto/topology/atlas_layout.h). Textures and vertex colours are sampled at the point of the original that belongs to
// each texel, so seams of the model's own texture coordinates do no harm. The result does not depend on the number of
// threads.
#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "terrain/model/image.h"
#include "terrain/model/model.h"
#include "terrain/remesh/original/original.h"
#include "terrain/remesh/remesh.h"
#include "terrain/surface_store/surface_format.h"

namespace foreland::terrain {

// A model and the images that its materials name.
struct Palette {
  const Model& model;
  std::vector<std::shared_ptr<const Image>> textures;  // of each material; null if the material has no texture
};

// Whether the model has colours of any kind: textures, vertex colours or materials.
[[nodiscard]] bool hasColours(const Palette& palette);

// Texel intervals along a base edge for which the image has about as many texels as the model uses of its textures, or
// four per coloured vertex; at least 4, and at most what an image can hold.
[[nodiscard]] uint32_t chooseSide(const Palette& palette, const Original& original, uint32_t base_faces);

struct Painted {
  proto::AtlasLayout atlas;
  std::vector<Texel> texels;
};
// `side` is at least 1 and rounded up as proto::AtlasLayout::of does. Error: an image beyond
// proto::AtlasLayout::kMaxPixels a side.
[[nodiscard]] Result<Painted> paint(const Palette& palette, const Original& original, const Remeshed& remeshed,
                                    uint32_t side, unsigned threads);

}  // namespace foreland::terrain
