#include "terrain/imagery/tile_picture.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace foreland::terrain {

using proto::kTilePayload;
using proto::kTileSide;
using proto::TileId;

std::unique_ptr<TilePicture> TilePicture::of(const std::shared_ptr<const Scene>& scene) {
  const auto layers = scene->tiles().layers();
  for (size_t i = 0; i < layers.size(); ++i)
    if (layers[i].content == proto::TileContent::kImagery)
      return std::unique_ptr<TilePicture>(new TilePicture(scene, static_cast<uint8_t>(i)));
  return nullptr;
}

TilePicture::TilePicture(std::shared_ptr<const Scene> scene, uint8_t layer) : scene_(std::move(scene)), layer_(layer) {}

const std::vector<Rgb>* TilePicture::pixelsOf(const TileId& tile) {
  const std::lock_guard lock(mutex_);
  const auto [found, is_new] = tiles_.try_emplace(tile.key());
  if (is_new) {
    auto pixels = std::make_unique<std::vector<Rgb>>(size_t{kTileSide} * kTileSide);
    if (decodeTile(scene_->tiles().bytes(tile), *pixels).ok()) found->second = std::move(pixels);
  }
  return found->second.get();
}

std::optional<glm::dvec3> TilePicture::at(const glm::dvec2& lattice, double width) {
  const proto::TileLayer& layer = scene_->tiles().layers()[layer_];
  const double face =
      layer.isGlobe() ? std::clamp(std::floor(lattice.x / layer.face_steps), 0.0, layer.faces() - 1.0) : 0;
  const glm::dvec2 origin = layer.origin + glm::dvec2(face * layer.face_steps, 0);
  uint32_t level = 0;
  while (level + 1 < layer.levels() && layer.texelAt(level) < width) ++level;
  for (; level < layer.levels(); ++level) {
    const glm::dvec2 texels = (lattice - origin) / layer.texelAt(level),
                     size(layer.widthAt(level), layer.heightAt(level));
    if (!(texels.x >= 0 && texels.y >= 0 && texels.x <= size.x && texels.y <= size.y)) return std::nullopt;
    const auto tileOf = [](double texel, uint32_t tiles) {
      return std::min(static_cast<uint32_t>(texel / kTilePayload), tiles - 1);
    };
    const TileId tile{layer_, static_cast<uint8_t>(level),
                      layer.xOf(level, static_cast<uint32_t>(face), tileOf(texels.x, layer.tilesX(level))),
                      tileOf(texels.y, layer.tilesY(level))};
    if (!scene_->tiles().bounds(tile)) continue;
    const std::vector<Rgb>* pixels = pixelsOf(tile);
    if (pixels == nullptr) return std::nullopt;
    const glm::dvec2 in_tile =
        texels - glm::dvec2(layer.columnOf(tile), tile.y) * (1.0 * kTilePayload) + (proto::kTileGutter - 0.5);
    const auto x = static_cast<size_t>(in_tile.x), y = static_cast<size_t>(in_tile.y);
    const double u = in_tile.x - static_cast<double>(x), v = in_tile.y - static_cast<double>(y);
    const auto colour = [&](size_t i, size_t j) {
      const Rgb& c = (*pixels)[j * kTileSide + i];
      return glm::dvec3(c[0], c[1], c[2]);
    };
    return (colour(x, y) * (1 - u) + colour(x + 1, y) * u) * (1 - v) +
           (colour(x, y + 1) * (1 - u) + colour(x + 1, y + 1) * u) * v;
  }
  return std::nullopt;
}

}  // namespace foreland::terrain
