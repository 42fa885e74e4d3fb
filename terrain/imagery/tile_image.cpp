#include "terrain/imagery/tile_image.h"

#include <algorithm>
#include <cmath>

#include "terrain/srgb.h"

namespace foreland::terrain {

namespace {

constexpr uint32_t kSide = proto::kTileSide, kHalf = kSide / 2;
constexpr Rgb kGrey{128, 128, 128};
constexpr double kFull = 65535;

const std::array<uint16_t, 256>& linearTable() {
  static const auto table = [] {
    std::array<uint16_t, 256> t{};
    for (size_t i = 0; i < t.size(); ++i)
      t[i] = static_cast<uint16_t>(std::lround(kFull * linearOfSrgb(static_cast<double>(i) / 255)));
    return t;
  }();
  return table;
}
const std::array<uint8_t, 65536>& srgbTable() {
  static const auto table = [] {
    std::array<uint8_t, 65536> t{};
    for (size_t i = 0; i < t.size(); ++i)
      t[i] = static_cast<uint8_t>(std::lround(255 * srgbOfLinear(static_cast<double>(i) / kFull)));
    return t;
  }();
  return table;
}

// Of what is shown, 0 to 1.
float luminance(const Rgb& c) {
  return (0.2126F * static_cast<float>(c[0]) + 0.7152F * static_cast<float>(c[1]) +
          0.0722F * static_cast<float>(c[2])) /
         255;
}

bool isCovered(const Rgba& texel) { return texel.alpha >= 128; }

// A colour (0 to 255) and how much is known of it.
struct Known {
  std::array<float, 3> colour{};
  float weight = 0;
};

// The means of 2 x 2, by weight.
std::vector<Known> pull(const std::vector<Known>& fine, uint32_t side) {
  std::vector<Known> coarse(size_t{side / 2} * (side / 2));
  for (uint32_t y = 0; y < side; ++y)
    for (uint32_t x = 0; x < side; ++x) {
      const Known& from = fine[size_t{y} * side + x];
      Known& to = coarse[size_t{y / 2} * (side / 2) + x / 2];
      for (size_t i = 0; i < 3; ++i) to.colour[i] += from.weight * from.colour[i];
      to.weight += from.weight;
    }
  for (Known& to : coarse) {
    if (to.weight > 0)
      for (float& c : to.colour) c /= to.weight;
    to.weight = std::min(to.weight, 1.0F);
  }
  return coarse;
}

// Blends what is not known with the coarser colours, enlarged.
void push(const std::vector<Known>& coarse, uint32_t side, std::vector<Known>& fine) {
  const uint32_t half = side / 2;
  const auto at = [&](uint32_t x, uint32_t y) { return coarse[size_t{y} * half + x]; };
  const auto beside = [&](uint32_t x) { return x % 2 ? std::min(x / 2 + 1, half - 1) : std::max(x / 2, 1u) - 1; };
  for (uint32_t y = 0; y < side; ++y)
    for (uint32_t x = 0; x < side; ++x) {
      Known& to = fine[size_t{y} * side + x];
      if (to.weight >= 1) continue;
      const Known near = at(x / 2, y / 2), a = at(beside(x), y / 2), b = at(x / 2, beside(y)),
                  c = at(beside(x), beside(y));
      for (size_t i = 0; i < 3; ++i) {
        const float enlarged = 0.5625F * near.colour[i] + 0.1875F * (a.colour[i] + b.colour[i]) + 0.0625F * c.colour[i];
        to.colour[i] = to.weight * to.colour[i] + (1 - to.weight) * enlarged;
      }
    }
}

}  // namespace

LinearTexel toLinear(const Rgba& t) {
  if (!isCovered(t)) return {};
  const auto& table = linearTable();
  return {table[t.red], table[t.green], table[t.blue], 65535};
}

Rgba toSrgb(const LinearTexel& t) {
  if (t.coverage == 0) return {};
  const auto& table = srgbTable();
  return {table[t.red], table[t.green], table[t.blue], 255};
}

LinearTexel meanOf(const LinearTexel& a, const LinearTexel& b, const LinearTexel& c, const LinearTexel& d) {
  const uint64_t weight = uint64_t{a.coverage} + b.coverage + c.coverage + d.coverage;
  if (weight == 0) return {};
  const auto mean = [&](uint16_t LinearTexel::*channel) {
    const uint64_t sum = uint64_t{a.*channel} * a.coverage + uint64_t{b.*channel} * b.coverage +
                         uint64_t{c.*channel} * c.coverage + uint64_t{d.*channel} * d.coverage;
    return static_cast<uint16_t>((sum + weight / 2) / weight);
  };
  return {mean(&LinearTexel::red), mean(&LinearTexel::green), mean(&LinearTexel::blue),
          static_cast<uint16_t>((weight + 3) / 4)};
}

// Source: "pull-push" of Gortler et al., "The Lumigraph" (1996), section 3.4.
std::vector<Rgb> filled(std::span<const Rgba> texels) {
  std::vector<Rgb> colours(texels.size(), kGrey);
  size_t covered = 0;
  for (size_t i = 0; i < texels.size(); ++i)
    if (isCovered(texels[i])) colours[i] = {texels[i].red, texels[i].green, texels[i].blue}, ++covered;
  if (covered == 0 || covered == texels.size()) return colours;
  std::vector<std::vector<Known>> levels(1, std::vector<Known>(texels.size()));
  for (size_t i = 0; i < texels.size(); ++i)
    if (isCovered(texels[i]))
      levels[0][i] = {
          {static_cast<float>(texels[i].red), static_cast<float>(texels[i].green), static_cast<float>(texels[i].blue)},
          1};
  for (uint32_t side = kSide; side > 1; side /= 2) levels.push_back(pull(levels.back(), side));
  uint32_t side = 1;
  for (size_t l = levels.size() - 1; l > 0; --l) push(levels[l], side *= 2, levels[l - 1]);
  for (size_t i = 0; i < texels.size(); ++i)
    for (size_t k = 0; k < 3; ++k) colours[i][k] = static_cast<uint8_t>(std::lround(levels[0][i].colour[k]));
  return colours;
}

float detailOf(std::span<const Rgba> texels, std::span<const Rgb> colours) {
  std::vector<float> parent(size_t{kHalf} * kHalf);
  for (uint32_t y = 0; y < kHalf; ++y)
    for (uint32_t x = 0; x < kHalf; ++x) {
      const auto linear = [&](uint32_t dx, uint32_t dy) {
        const Rgb& c = colours[size_t{2 * y + dy} * kSide + 2 * x + dx];
        return toLinear({c[0], c[1], c[2], 255});
      };
      const Rgba mean = toSrgb(meanOf(linear(0, 0), linear(1, 0), linear(0, 1), linear(1, 1)));
      parent[size_t{y} * kHalf + x] = luminance({mean.red, mean.green, mean.blue});
    }
  double squares = 0;
  uint64_t count = 0;
  constexpr uint32_t kEnd = kSide - proto::kTileGutter;
  for (uint32_t y = proto::kTileGutter; y < kEnd; ++y)
    for (uint32_t x = proto::kTileGutter; x < kEnd; ++x) {
      const size_t at = size_t{y} * kSide + x;
      if (!isCovered(texels[at])) continue;
      // The centre of a texel lies a quarter of the parent's texel from that one's centre.
      const float* near = &parent[size_t{y / 2} * kHalf + x / 2];
      const ptrdiff_t dx = x % 2 ? 1 : -1, dy = (y % 2 ? 1 : -1) * static_cast<ptrdiff_t>(kHalf);
      const float enlarged = 0.5625F * near[0] + 0.1875F * (near[dx] + near[dy]) + 0.0625F * near[dx + dy];
      const double difference = luminance(colours[at]) - enlarged;
      squares += difference * difference, ++count;
    }
  return count == 0 ? 0 : static_cast<float>(std::min(1.0, std::sqrt(squares / static_cast<double>(count))));
}

}  // namespace foreland::terrain
