#include "lab/drape/layer_image.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>

#include "base/check.h"
#include "proto/imagery/relief_codec.h"
#include "terrain/geo/geodesy.h"
#include "terrain/imagery/webp.h"
#include "terrain/srgb.h"

namespace foreland::lab {

namespace {

constexpr size_t kMaxKept = 1200;  // tiles, of half a megabyte each

float spacingOf(const terrain::Scene& scene) {
  const proto::GridShape& shape = scene.grid().shape();
  const glm::dvec2 spacing_m = terrain::sampleSpacing(scene.frame(), shape.samples_x, shape.samples_y);
  return static_cast<float>(0.5 * (spacing_m.x + spacing_m.y));
}

// Luminance (BT.709) in linear light, in which the card filters, too.
float luminanceOf(const terrain::Rgb& colour) {
  const auto linear = [&](size_t i) { return terrain::linearOfSrgb(colour[i] / 255.0); };
  return static_cast<float>(0.2126 * linear(0) + 0.7152 * linear(1) + 0.0722 * linear(2));
}

}  // namespace

LayerImage::LayerImage(std::shared_ptr<const terrain::Scene> scene, uint8_t layer)
    : scene_(std::move(scene)), layer_(layer), metres_a_step_(spacingOf(*scene_)) {}

LayerImage::Texels LayerImage::decodeHeights(const proto::TileId& tile) const {
  constexpr uint32_t kSide = proto::kTileSide;
  std::vector<int32_t> steps(proto::kTileTexels);
  CHECK_TRUE(proto::decodeRelief(scene_->tiles().bytes(tile), steps).ok());
  const auto a_level = static_cast<double>(uint64_t{1} << tile.level);
  const double slope = layer().step_m * a_level / (layer().texel * a_level * metres_a_step_);
  Texels out(proto::kTileTexels);
  for (uint32_t y = 0; y < kSide; ++y)
    for (uint32_t x = 0; x < kSide; ++x) {
      const uint32_t x0 = x > 0 ? x - 1 : x, x1 = std::min(x + 1, kSide - 1), y0 = y > 0 ? y - 1 : y,
                     y1 = std::min(y + 1, kSide - 1);
      const auto difference = [&](uint32_t to, uint32_t from, uint32_t apart) {
        return static_cast<float>(slope * (steps[to] - steps[from]) / apart);
      };
      out[y * kSide + x] = {difference(y * kSide + x1, y * kSide + x0, x1 - x0),
                            difference(y1 * kSide + x, y0 * kSide + x, y1 - y0)};
    }
  return out;
}

LayerImage::Texels LayerImage::decode(const proto::TileId& tile) const {
  if (layer().content == proto::TileContent::kRelief) return decodeHeights(tile);
  std::vector<terrain::Rgb> pixels(proto::kTileTexels);
  CHECK_TRUE(terrain::decodeTile(scene_->tiles().bytes(tile), pixels).ok());
  Texels out(proto::kTileTexels);
  for (size_t i = 0; i < out.size(); ++i) out[i] = {luminanceOf(pixels[i]), 0};
  return out;
}

const LayerImage::Texels& LayerImage::texels(const proto::TileId& tile) {
  if (const auto found = kept_.find(tile.key()); found != kept_.end()) {
    order_.splice(order_.begin(), order_, found->second.place);
    return found->second.texels;
  }
  if (kept_.size() >= kMaxKept) {
    kept_.erase(order_.back());
    order_.pop_back();
  }
  order_.push_front(tile.key());
  return kept_.emplace(tile.key(), Kept{decode(tile), order_.begin()}).first->second.texels;
}

proto::TileId LayerImage::tileAt(const glm::dvec2& lattice, uint32_t level) const {
  const glm::dvec2 at = (lattice - layer().origin) / (layer().texelAt(level) * proto::kTilePayload);
  const auto within = [](double v, uint32_t count) { return static_cast<uint32_t>(std::clamp(v, 0.0, count - 1.0)); };
  return {layer_, static_cast<uint8_t>(level), within(at.x, layer().tilesX(level)),
          within(at.y, layer().tilesY(level))};
}

bool LayerImage::hasFiner(const glm::dvec2& lattice, uint32_t level) const {
  return level > 0 && scene_->tiles().bounds(tileAt(lattice, level - 1)).has_value();
}

glm::vec2 LayerImage::at(const glm::dvec2& lattice, uint32_t level) {
  const uint32_t last = layer().levels() - 1;
  level = std::min(level, last);
  const glm::dvec2 texel = (lattice - layer().origin) / layer().texelAt(level);
  const proto::TileId tile = tileAt(lattice, level);
  if (level < last && !scene_->tiles().bounds(tile)) return at(lattice, level + 1);
  const double most = proto::kTileSide - 1.001;
  const double x = std::clamp(texel.x - proto::kTilePayload * tile.x + proto::kTileGutter - 0.5, 0.0, most),
               y = std::clamp(texel.y - proto::kTilePayload * tile.y + proto::kTileGutter - 0.5, 0.0, most);
  const glm::vec2* at = texels(tile).data() + static_cast<size_t>(y) * proto::kTileSide + static_cast<size_t>(x);
  const auto u = static_cast<float>(x - std::floor(x)), v = static_cast<float>(y - std::floor(y));
  return (1 - v) * ((1 - u) * at[0] + u * at[1]) + v * ((1 - u) * at[proto::kTileSide] + u * at[proto::kTileSide + 1]);
}

glm::vec2 LayerImage::at(const glm::dvec2& lattice, double lod) {
  const double below = std::floor(std::max(lod, 0.0));
  const auto level = static_cast<uint32_t>(below);
  const auto part = static_cast<float>(std::max(lod, 0.0) - below);
  const glm::vec2 fine = at(lattice, level);
  return part > 0 ? fine + part * (at(lattice, level + 1) - fine) : fine;
}

float LayerImage::brightness(const glm::vec2& value) const {
  if (layer().content == proto::TileContent::kImagery) return static_cast<float>(terrain::srgbOfLinear(value.x));
  const glm::vec3 normal = glm::normalize(glm::vec3(-value.x, -value.y, 1)),
                  sun = glm::normalize(glm::vec3(-1, 1, 1.4f));
  return static_cast<float>(terrain::srgbOfLinear(0.12f + 0.88f * std::max(glm::dot(normal, sun), 0.0f)));
}

}  // namespace foreland::lab
