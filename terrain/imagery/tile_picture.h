// The colours of a scene's imagery at places of its lattice, as a viewer with all tiles sees them. Tiles are decoded
// when they are first asked for, and kept: 200 kB each. Any thread.
#pragma once

#include <cstdint>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <memory>
#include <mutex>
#include <optional>
#include <unordered_map>
#include <vector>

#include "terrain/imagery/webp.h"
#include "terrain/store/scene.h"

namespace foreland::terrain {

class TilePicture {
 public:
  // Nothing if the scene has no imagery.
  static std::unique_ptr<TilePicture> of(const std::shared_ptr<const Scene>& scene);

  // sRGB, 0 to 255, bilinear: of the finest tile that is stored about a lattice position, but of none whose texels are
  // smaller than `width` sample intervals. Nothing beyond the picture, or where a tile is damaged.
  std::optional<glm::dvec3> at(const glm::dvec2& lattice, double width);

 private:
  TilePicture(std::shared_ptr<const Scene> scene, uint8_t layer);
  const std::vector<Rgb>* pixelsOf(const proto::TileId& tile);

  std::shared_ptr<const Scene> scene_;
  uint8_t layer_;
  std::mutex mutex_;
  std::unordered_map<uint64_t, std::unique_ptr<std::vector<Rgb>>> tiles_;  // decoded; null: damaged
};

}  // namespace foreland::terrain
