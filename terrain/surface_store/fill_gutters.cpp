#include "terrain/surface_store/fill_gutters.h"

#include <algorithm>
#include <array>
#include <vector>

#include "base/check.h"
#include "terrain/parallel.h"

namespace foreland::terrain {

namespace {

using proto::HalfEdge;

constexpr int kMaxEdgesCrossed = 16;

class Sewing {
 public:
  Sewing(const proto::AtlasLayout& atlas, const proto::BaseMesh& mesh, std::span<Texel> texels)
      : atlas_(atlas), mesh_(mesh), texels_(texels), side_(static_cast<int32_t>(atlas.side)) {}

  // Gives all texels at a vertex the colour that one of its faces has there.
  void shareEdge(HalfEdge h) {
    if (!mesh_.isFirst(h))
      for (int32_t step = 1; step < side_; ++step) onSide(h, step) = onSide(mesh_.twin(h), side_ - step);
    onSide(h, 0) = onSide(mesh_.leaving(mesh_.vertex(h)), 0);
  }

  void fillGutter(uint32_t face) {
    const proto::AtlasLayout::Span rows = atlas_.rowsOf(face);
    for (int32_t j = rows.begin; j < rows.end; ++j) {
      const proto::AtlasLayout::Span columns = atlas_.columnsOf(face, j);
      for (int32_t i = columns.begin; i < columns.end; ++i) {
        if (i >= 0 && j >= 0 && i + j <= side_) continue;
        texel(face, i, j) = i > 0 && j > 0 && i + j == side_ + 1 ? continued(face, i, j) : unfolded(face, i, j);
      }
    }
  }

 private:
  Texel& texel(uint32_t face, int32_t i, int32_t j) {
    const glm::ivec2 p = atlas_.pixel(face, i, j);
    return texels_[static_cast<uint64_t>(p.y) * atlas_.width() + static_cast<uint64_t>(p.x)];
  }
  // Texel number `step` along a half-edge, in its own face.
  Texel& onSide(HalfEdge h, int32_t step) {
    const int32_t back = side_ - step;
    if (h % 3 == 0) return texel(h / 3, step, 0);
    return h % 3 == 1 ? texel(h / 3, back, step) : texel(h / 3, 0, back);
  }

  // Along the hypotenuse, the fourth texel of a square extends the other three linearly: bilinear filtering then
  // interpolates along it as it does along the other two sides.
  Texel continued(uint32_t face, int32_t i, int32_t j) {
    const Texel left = texel(face, i - 1, j), above = texel(face, i, j - 1), both = texel(face, i - 1, j - 1);
    Texel result = 0;
    for (int shift = 0; shift < 32; shift += 8) {
      const auto channel = [&](Texel t) { return static_cast<int32_t>(t >> shift & 255); };
      const int32_t value = std::clamp(channel(left) + channel(above) - channel(both), 0, 255);
      result |= static_cast<Texel>(value) << shift;
    }
    return result;
  }

  // The texel at barycentric weights outside the face: neighbouring faces are unfolded into its plane, each as the
  // parallelogram over their edge. Beyond a border, or after too many faces, the weights are clamped to the last face.
  Texel unfolded(uint32_t face, int32_t i, int32_t j) {
    std::array<int32_t, 3> weights{side_ - i - j, i, j};
    for (int crossed = 0; crossed < kMaxEdgesCrossed; ++crossed) {
      const auto least = static_cast<uint32_t>(std::min_element(weights.begin(), weights.end()) - weights.begin());
      if (weights[least] >= 0) break;
      const HalfEdge across = 3 * face + (least + 1) % 3, twin = mesh_.twin(across);
      if (twin == proto::kNoHalfEdge) break;
      const int32_t over = -weights[least], first = weights[(least + 1) % 3], second = weights[(least + 2) % 3];
      face = twin / 3;
      weights[twin % 3] = second - over;
      weights[(twin % 3 + 1) % 3] = first - over;
      weights[(twin % 3 + 2) % 3] = over;
    }
    return nearest(face, weights);
  }
  Texel nearest(uint32_t face, std::array<int32_t, 3> weights) {
    for (int32_t& w : weights) w = std::max(w, 0);
    while (weights[0] + weights[1] + weights[2] > side_) --*std::max_element(weights.begin(), weights.end());
    return texel(face, weights[1], weights[2]);
  }

  const proto::AtlasLayout& atlas_;
  const proto::BaseMesh& mesh_;
  std::span<Texel> texels_;
  int32_t side_;
};

}  // namespace

void fillGutters(const proto::AtlasLayout& atlas, const proto::BaseMesh& mesh, std::span<Texel> texels,
                 unsigned threads) {
  CHECK_EQ(texels.size(), uint64_t{atlas.width()} * atlas.height());
  if (texels.empty()) return;
  CHECK_EQ(atlas.faces, mesh.faceCount());
  Sewing sewing(atlas, mesh, texels);
  for (HalfEdge h = 0; h < 3 * atlas.faces; ++h) sewing.shareEdge(h);
  parallelFor(
      atlas.faces, threads, [&](uint64_t face, unsigned) { sewing.fillGutter(static_cast<uint32_t>(face)); },
      [](uint64_t) { return true; });
  for (uint32_t y = 0; y < atlas.height(); ++y)
    for (uint32_t x = 0; x < atlas.width(); ++x)
      if (!atlas.faceAt({x, y})) texels[uint64_t{y} * atlas.width() + x] = 0;
}

std::optional<std::string> findSeam(const proto::AtlasLayout& atlas, const proto::BaseMesh& mesh,
                                    std::span<const Texel> texels, unsigned threads) {
  std::vector<Texel> filled(texels.begin(), texels.end());
  fillGutters(atlas, mesh, filled, threads);
  const auto differs = std::mismatch(filled.begin(), filled.end(), texels.begin());
  if (differs.first == filled.end()) return std::nullopt;
  const auto at = static_cast<uint64_t>(differs.first - filled.begin());
  const glm::uvec2 pixel(at % atlas.width(), at / atlas.width());
  const std::string name = "pixel (" + std::to_string(pixel.x) + ", " + std::to_string(pixel.y) + ") of the image ";
  const std::optional<uint32_t> face = atlas.faceAt(pixel);
  return name + (face ? "is not what base face " + std::to_string(*face) + " must have there" : "should be 0");
}

}  // namespace foreland::terrain
