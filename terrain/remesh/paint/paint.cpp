#include "terrain/remesh/paint/paint.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <glm/vec4.hpp>
#include <span>
#include <utility>

#include "terrain/parallel.h"
#include "terrain/remesh/paint/point_location.h"
#include "terrain/srgb.h"
#include "terrain/surface_store/fill_gutters.h"

namespace foreland::terrain {

namespace {

using glm::dvec3;
using glm::dvec4;

dvec4 toVector(const Colour& c) { return {c[0], c[1], c[2], c[3]}; }
Texel toTexel(const dvec4& colour) {
  Texel texel = 0;
  for (int k = 0; k < 4; ++k) texel |= static_cast<Texel>(std::lround(std::clamp(colour[k], 0.0, 255.0))) << (8 * k);
  return texel;
}

// Bilinear, with repeating images as models expect. Texture coordinate (0, 0) is the lower left corner.
dvec4 sample(const Image& image, const glm::dvec2& at) {
  const double x = (at.x - std::floor(at.x)) * image.width - 0.5;
  const double y = (1 - (at.y - std::floor(at.y))) * image.height - 0.5;
  const double left = std::floor(x), top = std::floor(y), u = x - left, v = y - top;
  const auto pixel = [&](double column, double row) {
    const auto wrap = [](double i, uint32_t size) {
      return static_cast<uint32_t>(i < 0 ? i + size : i >= size ? i - size : i);
    };
    return toVector(image.at(wrap(column, image.width), wrap(row, image.height)));
  };
  return (1 - v) * ((1 - u) * pixel(left, top) + u * pixel(left + 1, top)) +
         v * ((1 - u) * pixel(left, top + 1) + u * pixel(left + 1, top + 1));
}

// `colour`, 0 to 255, with each channel multiplied by its share of light.
dvec4 tinted(dvec4 colour, const glm::dvec4& tint) {
  if (tint == glm::dvec4(1)) return colour;
  for (int k = 0; k < 3; ++k) colour[k] = 255 * srgbOfLinear(tint[k] * linearOfSrgb(colour[k] / 255));
  colour.a *= tint.a;
  return colour;
}

// The colour of the original at one of its points.
class OriginalColours {
 public:
  OriginalColours(const Palette& palette, const Original& original) : palette_(palette), original_(original) {}

  dvec4 at(const SurfacePoint& point) const {
    const Model& model = palette_.model;
    const uint32_t material = model.face_materials[original_.source_faces[point.face]];
    std::array<Corner, 3> corners;
    for (size_t k = 0; k < 3; ++k) corners[k] = model.corners[original_.source_corners[point.face][k]];
    const bool is_textured =
        material != kNoIndex && palette_.textures[material] != nullptr &&
        std::none_of(corners.begin(), corners.end(), [](const Corner& c) { return c.texture == kNoIndex; });
    if (is_textured) {
      glm::dvec2 coordinate(0);
      for (int k = 0; k < 3; ++k)
        coordinate += point.weights[k] * model.texture_coordinates[corners[static_cast<size_t>(k)].texture];
      return tinted(sample(*palette_.textures[material], coordinate), model.materials[material].tint);
    }
    if (!model.face_colours.empty()) return toVector(model.face_colours[original_.source_faces[point.face]]);
    if (!model.colours.empty()) {
      dvec4 colour(0);
      for (int k = 0; k < 3; ++k)
        colour += point.weights[k] * toVector(model.colours[corners[static_cast<size_t>(k)].vertex]);
      return colour;
    }
    return material == kNoIndex ? dvec4(255) : toVector(model.materials[material].colour);
  }

 private:
  const Palette& palette_;
  const Original& original_;
};

class Painter {
 public:
  Painter(const Palette& palette, const Original& original, const Remeshed& remeshed, const proto::AtlasLayout& atlas)
      : colours_(palette, original),
        original_(original),
        remeshed_(remeshed),
        mesh_(
            proto::BaseMesh::create(static_cast<uint32_t>(remeshed.base_vertices.size()), remeshed.base_faces).value()),
        side_(static_cast<int32_t>(atlas.side)) {
    painted_.atlas = atlas;
    painted_.texels.resize(uint64_t{atlas.width()} * atlas.height());
  }

  Painted run(unsigned threads) {
    parallelFor(
        mesh_.faceCount(), threads, [&](uint64_t f, unsigned) { fill(static_cast<uint32_t>(f)); },
        [](uint64_t) { return true; });
    fillGutters(painted_.atlas, mesh_, painted_.texels, threads);
    return std::move(painted_);
  }

 private:
  Texel& texel(uint32_t face, int32_t i, int32_t j) {
    const glm::ivec2 p = painted_.atlas.pixel(face, i, j);
    return painted_.texels[static_cast<uint64_t>(p.y) * painted_.atlas.width() + static_cast<uint64_t>(p.x)];
  }
  void fill(uint32_t face) {
    for (int32_t j = 0; j <= side_; ++j)
      for (int32_t i = 0; i + j <= side_; ++i) {
        const dvec3 weights = dvec3(side_ - i - j, i, j) / double(side_);
        texel(face, i, j) = toTexel(colours_.at(locateOnOriginal(original_, remeshed_, face, weights)));
      }
  }

  OriginalColours colours_;
  const Original& original_;
  const Remeshed& remeshed_;
  proto::BaseMesh mesh_;
  int32_t side_;
  Painted painted_;
};

}  // namespace

bool hasColours(const Palette& palette) {
  return !palette.model.colours.empty() || !palette.model.face_colours.empty() ||
         std::any_of(palette.model.face_materials.begin(), palette.model.face_materials.end(),
                     [](uint32_t material) { return material != kNoIndex; });
}

uint32_t chooseSide(const Palette& palette, const Original& original, uint32_t base_faces) {
  double texels = palette.model.colours.empty() ? 0 : 4.0 * static_cast<double>(original.positions.size());
  if (!palette.model.face_colours.empty()) texels += 4.0 * static_cast<double>(original.faces.size());
  for (uint32_t f = 0; f < original.faces.size(); ++f) {
    const uint32_t material = palette.model.face_materials[original.source_faces[f]];
    if (material == kNoIndex || palette.textures[material] == nullptr) continue;
    std::array<glm::dvec2, 3> at{};
    for (size_t k = 0; k < 3; ++k) {
      const uint32_t coordinate = palette.model.corners[original.source_corners[f][k]].texture;
      if (coordinate != kNoIndex) at[k] = palette.model.texture_coordinates[coordinate];
    }
    texels += std::fabs(doubledArea(at[0], at[1], at[2])) / 2 *
              static_cast<double>(palette.textures[material]->pixels.size());
  }
  uint32_t side = static_cast<uint32_t>(std::clamp(std::ceil(std::sqrt(2 * texels / base_faces)), 4.0, 4096.0));
  const auto fits = [&] {
    const proto::AtlasLayout atlas = proto::AtlasLayout::of(base_faces, side);
    return std::max(atlas.width(), atlas.height()) <= proto::AtlasLayout::kMaxPixels;
  };
  while (side > 4 && !fits()) side = side * 9 / 10;
  return side;
}

Result<Painted> paint(const Palette& palette, const Original& original, const Remeshed& remeshed, uint32_t side,
                      unsigned threads) {
  const proto::AtlasLayout atlas = proto::AtlasLayout::of(static_cast<uint32_t>(remeshed.base_faces.size()), side);
  if (std::max(atlas.width(), atlas.height()) > proto::AtlasLayout::kMaxPixels)
    return Error{ErrorCode::kLimit, std::to_string(side) + " texels along a base edge make an image of more than " +
                                        std::to_string(proto::AtlasLayout::kMaxPixels) +
                                        " pixels a side; ask for fewer, or for none"};
  return Painter(palette, original, remeshed, atlas).run(threads);
}

}  // namespace foreland::terrain
