// The image of a surface: at each of its sizes, whoever filters it at a place of a face reads pixels of that face
// alone, and they hold what lies around that place.
#include "terrain/surface_store/fill_gutters.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <set>
#include <string>
#include <vector>

#include "base/rng.h"
#include "tests/support/base_meshes.h"

namespace foreland::terrain {
namespace {

using proto::BaseFace;

TEST(AtlasLayout, EveryPixelIsOneFacesOwn) {
  for (const uint32_t faces : {1u, 2u, 7u, 200u})
    for (const uint32_t side : {1u, 4u, 17u}) {
      const proto::AtlasLayout atlas = proto::AtlasLayout::of(faces, side);
      EXPECT_GE(atlas.side, side);
      EXPECT_EQ(atlas.width() % proto::AtlasLayout::kUnit + atlas.height() % proto::AtlasLayout::kUnit, 0u);
      std::vector<uint32_t> owner(uint64_t{atlas.width()} * atlas.height(), faces);
      for (uint32_t face = 0; face < faces; ++face)
        for (int32_t j = atlas.rowsOf(face).begin; j < atlas.rowsOf(face).end; ++j)
          for (int32_t i = atlas.columnsOf(face, j).begin; i < atlas.columnsOf(face, j).end; ++i) {
            const glm::ivec2 p = atlas.pixel(face, i, j);
            ASSERT_TRUE(p.x >= 0 && p.y >= 0 && p.x < static_cast<int32_t>(atlas.width()) &&
                        p.y < static_cast<int32_t>(atlas.height()));
            uint32_t& taken = owner[static_cast<uint64_t>(p.y) * atlas.width() + static_cast<uint64_t>(p.x)];
            ASSERT_EQ(taken, faces);
            taken = face;
          }
      for (uint32_t y = 0; y < atlas.height(); ++y)
        for (uint32_t x = 0; x < atlas.width(); ++x)
          ASSERT_EQ(atlas.faceAt({x, y}).value_or(faces), owner[uint64_t{y} * atlas.width() + x]);
    }
}

TEST(AtlasLayout, CoordinatesFallOnTexelCentres) {
  const proto::AtlasLayout atlas = proto::AtlasLayout::of(9, 8);
  for (uint32_t face = 0; face < 9; ++face)
    for (int32_t j = 0; j <= 8; ++j)
      for (int32_t i = 0; i + j <= 8; ++i) {
        const glm::dvec2 at = atlas.coordinates(face, glm::dvec3(8 - i - j, i, j) / 8.0);
        const glm::dvec2 pixel = glm::dvec2(atlas.pixel(face, i, j)) + 0.5;
        EXPECT_NEAR(at.x * atlas.width(), pixel.x, 1e-9);
        EXPECT_NEAR(at.y * atlas.height(), pixel.y, 1e-9);
      }
}

// Corners, middles of sides, and anywhere.
std::vector<glm::dvec3> placesOfAFace(Rng& rng) {
  std::vector<glm::dvec3> places{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
  for (int i = 0; i < 300; ++i) {
    const double u = rng.uniform(), v = rng.uniform() * (1 - u);
    places.emplace_back(1 - u - v, u, v);
    places.emplace_back(u, 1 - u, 0), places.emplace_back(0, u, 1 - u), places.emplace_back(1 - u, 0, u);
  }
  return places;
}

// Where a bilinear filter reads the image that was halved so often: squares of 2^halvings pixels.
TEST(AtlasLayout, FiltersReadPixelsOfTheirFaceAlone) {
  constexpr uint64_t kSeed = 5;
  SCOPED_TRACE(kSeed);
  Rng rng(kSeed);
  for (const uint32_t side : {4u, 8u, 12u, 32u}) {
    const proto::AtlasLayout atlas = proto::AtlasLayout::of(5, side);
    for (uint32_t face = 0; face < 5; ++face)
      for (const glm::dvec3& weights : placesOfAFace(rng))
        for (uint32_t halvings = 0; halvings <= proto::AtlasLayout::kHalvings; ++halvings) {
          const double size = 1u << halvings;
          const glm::dvec2 at = atlas.coordinates(face, weights) * glm::dvec2(atlas.width(), atlas.height()) / size;
          for (const double x : {at.x - 0.5, at.x + 0.5 - 1e-9})
            for (const double y : {at.y - 0.5, at.y + 0.5 - 1e-9})
              for (const double dx : {0.0, size - 1})
                for (const double dy : {0.0, size - 1}) {
                  const glm::uvec2 pixel(std::floor(x) * size + dx, std::floor(y) * size + dy);
                  ASSERT_LT(pixel.x, atlas.width());
                  ASSERT_LT(pixel.y, atlas.height());
                  ASSERT_EQ(atlas.faceAt(pixel), face)
                      << side << ' ' << halvings << ' ' << weights.x << ' ' << weights.y;
                }
        }
  }
}

struct FilledAtlas {
  proto::AtlasLayout atlas;
  proto::BaseMesh mesh;
  std::vector<Texel> texels;

  FilledAtlas(const test::NamedBase& base, uint32_t side)
      : atlas(proto::AtlasLayout::of(static_cast<uint32_t>(base.faces.size()), side)),
        mesh(proto::BaseMesh::create(base.vertices, base.faces).value()),
        texels(uint64_t{atlas.width()} * atlas.height(), 0xdeadbeef) {}
  Texel& at(uint32_t face, int32_t i, int32_t j) {
    const glm::ivec2 p = atlas.pixel(face, i, j);
    return texels[static_cast<uint64_t>(p.y) * atlas.width() + static_cast<uint64_t>(p.x)];
  }
  bool isInside(int32_t i, int32_t j) const { return i >= 0 && j >= 0 && i + j <= static_cast<int32_t>(atlas.side); }
  // The one row that is not a copy of other texels.
  bool isContinued(int32_t i, int32_t j) const {
    return i > 0 && j > 0 && i + j == static_cast<int32_t>(atlas.side) + 1;
  }
  template <class Visit>
  void forEach(const Visit& visit) {
    for (uint32_t face = 0; face < atlas.faces; ++face)
      for (int32_t j = atlas.rowsOf(face).begin; j < atlas.rowsOf(face).end; ++j)
        for (int32_t i = atlas.columnsOf(face, j).begin; i < atlas.columnsOf(face, j).end; ++i) visit(face, i, j);
  }
  void fill(unsigned threads = 1) { fillGutters(atlas, mesh, texels, threads); }
};

// A torus of squares lies in the plane without a crease: beyond every edge, the plane's own colour comes next.
TEST(FillGutters, AFlatTorusContinuesBeyondItsEdges) {
  constexpr int32_t kSquares = 3;
  constexpr uint64_t kSeed = 6;
  SCOPED_TRACE(kSeed);
  for (const uint32_t side : {4u, 12u}) {
    const int32_t step = static_cast<int32_t>(side), period = kSquares * step;
    Rng rng(kSeed);
    std::vector<Texel> plane(static_cast<size_t>(period * period));
    for (Texel& texel : plane) texel = static_cast<Texel>(rng.next());
    const auto colour = [&](const glm::ivec2& p) {
      const auto wrap = [&](int32_t x) { return static_cast<size_t>((x % period + period) % period); };
      return plane[wrap(p.y) * static_cast<size_t>(period) + wrap(p.x)];
    };
    const test::NamedBase base = test::shuffled(test::torusBase(kSquares, kSquares), 7);
    const auto place = [&](uint32_t face, int32_t i, int32_t j) {
      const auto corner = [&](size_t k) {
        const auto v = static_cast<int32_t>(base.faces[face][k]);
        return glm::ivec2(v % kSquares, v / kSquares);
      };
      const auto nearest = [&](int32_t d) { return d > 1 ? d - kSquares : d < -1 ? d + kSquares : d; };
      const auto way = [&](size_t k) {
        const glm::ivec2 d = corner(k) - corner(0);
        return glm::ivec2(nearest(d.x), nearest(d.y));
      };
      return corner(0) * step + i * way(1) + j * way(2);
    };
    FilledAtlas filled(base, side);
    filled.forEach([&](uint32_t face, int32_t i, int32_t j) {
      if (filled.isInside(i, j)) filled.at(face, i, j) = colour(place(face, i, j));
    });
    filled.fill();
    filled.forEach([&](uint32_t face, int32_t i, int32_t j) {
      if (filled.isContinued(i, j)) return;
      ASSERT_EQ(filled.at(face, i, j), colour(place(face, i, j))) << "face " << face << ": " << i << ", " << j;
    });
  }
}

// Each face in a colour of its own: around it stand colours of faces that touch it, and nothing else.
TEST(FillGutters, GuttersHoldColoursOfFacesThatTouch) {
  for (const test::NamedBase& base : test::baseMeshes()) {
    SCOPED_TRACE(base.name);
    FilledAtlas filled(base, 16);
    filled.forEach([&](uint32_t face, int32_t i, int32_t j) {
      if (filled.isInside(i, j)) filled.at(face, i, j) = face;
    });
    filled.fill();
    filled.forEach([&](uint32_t face, int32_t i, int32_t j) {
      if (filled.isContinued(i, j)) return;
      const Texel found = filled.at(face, i, j);
      ASSERT_LT(found, filled.atlas.faces);
      const BaseFace &here = base.faces[face], &there = base.faces[found];
      ASSERT_NE(std::find_first_of(here.begin(), here.end(), there.begin(), there.end()), here.end())
          << "face " << face << ": " << i << ", " << j << " is of face " << found;
    });
  }
}

TEST(FillGutters, ADoneImageStaysAndAnyOtherPixelIsNamed) {
  constexpr uint64_t kSeed = 8;
  SCOPED_TRACE(kSeed);
  Rng rng(kSeed);
  for (const test::NamedBase& base : test::baseMeshes()) {
    SCOPED_TRACE(base.name);
    FilledAtlas filled(base, 4);
    for (Texel& texel : filled.texels) texel = static_cast<Texel>(rng.next());
    FilledAtlas other = filled;
    filled.fill(1);
    other.fill(3);
    ASSERT_EQ(filled.texels, other.texels);
    ASSERT_EQ(findSeam(filled.atlas, filled.mesh, filled.texels, 1), std::nullopt);
    for (int n = 0; n < 60; ++n) {
      const glm::uvec2 pixel(rng.below(filled.atlas.width()), rng.below(filled.atlas.height()));
      Texel& texel = filled.texels[uint64_t{pixel.y} * filled.atlas.width() + pixel.x];
      const Texel before = std::exchange(texel, texel ^ 0x01000000);
      const auto seam = findSeam(filled.atlas, filled.mesh, filled.texels, 1);
      bool is_inside = false;
      filled.forEach([&](uint32_t face, int32_t i, int32_t j) {
        is_inside |= glm::uvec2(filled.atlas.pixel(face, i, j)) == pixel && filled.isInside(i, j);
      });
      if (!is_inside) {
        ASSERT_TRUE(seam.has_value());
        EXPECT_EQ(seam->find("pixel (" + std::to_string(pixel.x) + ", " + std::to_string(pixel.y) + ") "), 0u) << *seam;
      }
      texel = before;
    }
  }
}

}  // namespace
}  // namespace foreland::terrain
