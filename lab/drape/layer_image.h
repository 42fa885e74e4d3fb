// A layer of tiles as an image of any level: for relief the slope of the ground, for imagery its luminance in linear
// light. Tiles are decoded when they are first looked at. One owner.
#pragma once

#include <cstdint>
#include <glm/vec2.hpp>
#include <list>
#include <memory>
#include <unordered_map>
#include <vector>

#include "proto/imagery/tile.h"
#include "terrain/store/scene.h"

namespace foreland::lab {

class LayerImage {
 public:
  LayerImage(std::shared_ptr<const terrain::Scene> scene, uint8_t layer);

  const proto::TileLayer& layer() const { return scene_->tiles().layers()[layer_]; }
  uint8_t index() const { return layer_; }

  // Bilinear between texels of a level, at a lattice position: slopes along the lattice's axes, or luminance and 0.
  // Where a tile is not stored, its parent's.
  glm::vec2 at(const glm::dvec2& lattice, uint32_t level);
  // Between two levels.
  glm::vec2 at(const glm::dvec2& lattice, double lod);

  // Whether a tile of the next finer level is stored at a position; others show the same as their parents.
  bool hasFiner(const glm::dvec2& lattice, uint32_t level) const;

  // What a pixel of this mean value looks like, 0 to 1: gamma-coded luminance; relief is lit from the north-west.
  float brightness(const glm::vec2& value) const;

 private:
  using Texels = std::vector<glm::vec2>;
  proto::TileId tileAt(const glm::dvec2& lattice, uint32_t level) const;
  const Texels& texels(const proto::TileId& tile);
  Texels decode(const proto::TileId& tile) const;
  Texels decodeHeights(const proto::TileId& tile) const;

  std::shared_ptr<const terrain::Scene> scene_;
  uint8_t layer_;
  float metres_a_step_;  // sample interval
  struct Kept {
    Texels texels;
    std::list<uint64_t>::iterator place;
  };
  std::unordered_map<uint64_t, Kept> kept_;
  std::list<uint64_t> order_;  // the last one used first
};

}  // namespace foreland::lab
