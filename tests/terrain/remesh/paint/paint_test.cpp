// Colours arrive where they belong, and both faces of an edge show the same along it.
#include "terrain/remesh/paint/paint.h"

#include <gtest/gtest.h>
#include <png.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <memory>
#include <numbers>

#include "base/rng.h"
#include "terrain/model/png.h"
#include "terrain/remesh/paint/point_location.h"
#include "terrain/remesh/remeshed_surface.h"
#include "tests/support/files.h"
#include "tests/support/models.h"

namespace foreland::terrain {
namespace {

using glm::dvec3;

// A colour for each direction, smooth.
Colour colourOf(const dvec3& p) {
  const dvec3 n = glm::normalize(p);
  return {static_cast<uint8_t>(std::lround(127.5 * (1 + n.x))), static_cast<uint8_t>(std::lround(127.5 * (1 + n.y))),
          static_cast<uint8_t>(std::lround(127.5 * (1 + n.z))), 255};
}

// As a graphics card filters: bilinear between the centres of four pixels. `at` in pixels.
std::array<double, 4> filtered(const std::vector<Texel>& texels, uint32_t width, const glm::dvec2& at) {
  const double left = std::floor(at.x - 0.5), top = std::floor(at.y - 0.5), u = at.x - 0.5 - left, v = at.y - 0.5 - top;
  std::array<double, 4> sum{};
  for (int dy : {0, 1})
    for (int dx : {0, 1}) {
      const auto column = static_cast<uint64_t>(left + dx), row = static_cast<uint64_t>(top + dy);
      const auto colour = std::bit_cast<Colour>(texels[row * width + column]);
      for (size_t k = 0; k < 4; ++k) sum[k] += (dx ? u : 1 - u) * (dy ? v : 1 - v) * colour[k];
    }
  return sum;
}

std::array<double, 4> filtered(const Painted& painted, const glm::dvec2& coordinates) {
  const glm::dvec2 size(painted.atlas.width(), painted.atlas.height());
  return filtered(painted.texels, painted.atlas.width(), coordinates * size);
}

using Textures = std::vector<std::shared_ptr<const Image>>;

struct Sphere {
  Model model = test::makeSphere(5);
  Original original;
  Remeshed remeshed;
  Sphere()
      : original(makeOriginal(model).value()),
        remeshed(remesh(original, {.base_triangles = 40, .levels = 4, .attempts = 1}).value()) {
    for (const dvec3& p : model.positions) model.colours.push_back(colourOf(p));
  }
};

TEST(Paint, VertexColoursArriveWhereTheyBelong) {
  const Sphere sphere;
  const Textures none;
  const Palette palette{sphere.model, none};
  ASSERT_TRUE(hasColours(palette));
  const auto painted = paint(palette, sphere.original, sphere.remeshed, 16, 2);
  ASSERT_TRUE(painted.ok());
  // With as many texels as lattice intervals, texels lie on lattice vertices.
  for (uint32_t face = 0; face < sphere.remeshed.base_faces.size(); ++face)
    for (uint32_t j = 0; j <= 16; ++j)
      for (uint32_t i = 0; i + j <= 16; ++i) {
        const dvec3& p = sphere.remeshed.positions[sphere.remeshed.lattice.vertex(face, i, j)];
        const Colour expected = colourOf(p);
        const auto found = filtered(*painted, painted->atlas.coordinates(face, dvec3(16 - i - j, i, j) / 16.0));
        for (size_t k = 0; k < 4; ++k) EXPECT_NEAR(found[k], expected[k], 2);
      }
}

TEST(Paint, ColoursOfFacesFillThem) {
  Model cube = test::inTriangles(test::makeCube(1));
  for (size_t face = 0; face < cube.faceCount(); ++face) {  // both triangles of a side alike
    const auto side = static_cast<uint8_t>(face / 2);
    cube.face_colours.push_back({static_cast<uint8_t>(40 * side), static_cast<uint8_t>(255 - 40 * side), 7, 255});
  }
  const Original original = makeOriginal(cube).value();
  const Remeshed remeshed = remesh(original, {.base_triangles = 12, .levels = 1, .attempts = 1}).value();
  const Textures none;
  const Palette palette{cube, none};
  ASSERT_TRUE(hasColours(palette));
  EXPECT_GE(chooseSide(palette, original, 12), 4u);
  const auto painted = paint(palette, original, remeshed, 12, 1);
  ASSERT_TRUE(painted.ok());
  // Where a texel lies in space says on which side of the cube it is.
  std::array<int, 6> seen{};
  for (uint32_t face = 0; face < remeshed.base_faces.size(); ++face)
    for (int32_t j = 0; j <= 12; ++j)
      for (int32_t i = 0; i + j <= 12; ++i) {
        const SurfacePoint point = locateOnOriginal(original, remeshed, face, dvec3(12 - i - j, i, j) / 12.0);
        const dvec3 p = positionOf(point, original.positions, original.faces);
        std::vector<int> sides;
        for (int axis = 0; axis < 3; ++axis)
          for (const int sign : {0, 1})
            if (std::fabs(p[axis] - sign) < 1e-9) sides.push_back(2 * axis + sign);
        if (sides.size() != 1) continue;  // on an edge
        const glm::ivec2 at = painted->atlas.pixel(face, i, j);
        const auto colour = std::bit_cast<Colour>(
            painted->texels[static_cast<uint64_t>(at.y) * painted->atlas.width() + static_cast<uint64_t>(at.x)]);
        EXPECT_EQ(colour, cube.face_colours[2 * static_cast<size_t>(sides[0])]);
        ++seen[static_cast<size_t>(sides[0])];
      }
  for (const int count : seen) EXPECT_GT(count, 20);
}

TEST(Paint, BothFacesOfAnEdgeShowTheSameAlongIt) {
  constexpr uint64_t kSeed = 17;
  SCOPED_TRACE(kSeed);
  Rng rng(kSeed);
  Sphere sphere;
  for (Colour& c : sphere.model.colours)  // as unlike from vertex to vertex as can be without saturating
    for (size_t k = 0; k < 3; ++k) c[k] = static_cast<uint8_t>(96 + rng.below(64));
  const Textures none;
  const auto painted = paint({sphere.model, none}, sphere.original, sphere.remeshed, 12, 2);
  ASSERT_TRUE(painted.ok());
  const auto mesh =
      proto::BaseMesh::create(static_cast<uint32_t>(sphere.remeshed.base_vertices.size()), sphere.remeshed.base_faces)
          .value();
  double most = 0;
  for (proto::HalfEdge h = 0; h < 3 * mesh.faceCount(); ++h)
    for (int step = 0; step <= 100; ++step) {
      const proto::HalfEdge twin = mesh.twin(h);
      const double t = step / 100.0;
      dvec3 here(0), there(0);
      here[static_cast<int>(h % 3)] = 1 - t, here[static_cast<int>((h % 3 + 1) % 3)] = t;
      there[static_cast<int>(twin % 3)] = t, there[static_cast<int>((twin % 3 + 1) % 3)] = 1 - t;
      const auto a = filtered(*painted, painted->atlas.coordinates(h / 3, here));
      const auto b = filtered(*painted, painted->atlas.coordinates(twin / 3, there));
      for (size_t k = 0; k < 4; ++k) most = std::max(most, std::fabs(a[k] - b[k]));
    }
  EXPECT_LE(most, 0.5);  // gutters are rounded to whole numbers
}

// The image at half its size, as graphics cards make it.
std::vector<Texel> halved(const std::vector<Texel>& texels, uint32_t width) {
  std::vector<Texel> half;
  for (size_t row = 0; row + width < texels.size(); row += 2 * width)
    for (size_t at = row; at < row + width; at += 2) {
      Colour mean{};
      for (size_t k = 0; k < 4; ++k) {
        int sum = 2;
        for (const size_t pixel : {at, at + 1, at + width, at + width + 1})
          sum += std::bit_cast<Colour>(texels[pixel])[k];
        mean[k] = static_cast<uint8_t>(sum / 4);
      }
      half.push_back(std::bit_cast<Texel>(mean));
    }
  return half;
}

// Nothing of another part of the image shows, at any of its sizes, in the middle of faces or along their edges.
TEST(Paint, SmallerImagesShowTheColoursThere) {
  constexpr uint64_t kSeed = 23;
  SCOPED_TRACE(kSeed);
  Rng rng(kSeed);
  const Sphere sphere;
  const Textures none;
  const auto painted = paint({sphere.model, none}, sphere.original, sphere.remeshed, 32, 2);
  ASSERT_TRUE(painted.ok());
  const glm::dvec2 size(painted->atlas.width(), painted->atlas.height());
  std::vector<Texel> texels = painted->texels;
  for (uint32_t halvings = 0; halvings <= proto::AtlasLayout::kHalvings; ++halvings) {
    const uint32_t width = painted->atlas.width() >> halvings;
    for (uint32_t face = 0; face < sphere.remeshed.base_faces.size(); ++face)
      for (int i = 0; i < 200; ++i) {
        const double u = rng.uniform(), v = i % 2 == 0 ? 0 : rng.uniform() * (1 - u);
        dvec3 weights(1 - u - v, u, v);
        if (i % 3 == 0) weights = {weights.z, weights.x, weights.y};
        if (i % 3 == 1) weights = {weights.y, weights.z, weights.x};
        const LatticeCell cell = sphere.remeshed.lattice.cellAt(face, weights);
        dvec3 place(0);
        for (int k = 0; k < 3; ++k)
          place += cell.weights[k] * sphere.remeshed.positions[cell.vertices[static_cast<size_t>(k)]];
        const auto found =
            filtered(texels, width, painted->atlas.coordinates(face, weights) * size / double(1u << halvings));
        const Colour expected = colourOf(place);
        for (size_t k = 0; k < 4; ++k) ASSERT_NEAR(found[k], expected[k], 4 << halvings) << face;
      }
    texels = halved(texels, width);
  }
}

TEST(Paint, DoesNotDependOnThreads) {
  const Sphere sphere;
  const Textures none;
  const Palette palette{sphere.model, none};
  const auto one = paint(palette, sphere.original, sphere.remeshed, 9, 1),
             five = paint(palette, sphere.original, sphere.remeshed, 9, 5);
  ASSERT_TRUE(one.ok() && five.ok());
  EXPECT_EQ(one->texels, five->texels);
}

// Sixteen shades along u, a seam where the texture's left meets its right: no texel may be a mix of both ends.
TEST(Paint, TexturesComeThroughTheirSeams) {
  constexpr uint32_t kAround = 64, kUp = 24;
  Model tube = test::makeGrid(kAround, kUp, {true, false}, [](double u, double v) {
    return dvec3(std::cos(2 * std::numbers::pi * u), std::sin(2 * std::numbers::pi * u), v);
  });
  for (uint32_t y = 0; y < kUp; ++y)
    for (uint32_t x = 0; x < kAround; ++x) {
      const uint64_t begin = tube.faceBegin(y * kAround + x);
      for (uint32_t k = 0; k < 4; ++k) {
        const uint32_t dx = k == 1 || k == 2, dy = k >= 2;
        tube.corners[begin + k].texture = static_cast<uint32_t>(tube.texture_coordinates.size());
        tube.texture_coordinates.emplace_back(double(x + dx) / kAround, double(y + dy) / kUp);
      }
    }
  tube.materials.push_back({"shades", "shades.png"});
  std::fill(tube.face_materials.begin(), tube.face_materials.end(), 0);
  Image image{256, 4, std::vector<Colour>(1024)};
  for (uint32_t i = 0; i < 1024; ++i) image.pixels[i] = {static_cast<uint8_t>(i % 256), 10, 20, 255};
  const Textures textures{std::make_shared<const Image>(image)};

  const Original original = makeOriginal(tube).value();
  const Remeshed remeshed = remesh(original, {.base_triangles = 60, .levels = 4, .attempts = 1}).value();
  const Palette palette{tube, textures};
  EXPECT_GT(chooseSide(palette, original, 60), 4u);
  const auto painted = paint(palette, original, remeshed, 16, 2);
  ASSERT_TRUE(painted.ok());
  for (uint32_t face = 0; face < remeshed.base_faces.size(); ++face)
    for (uint32_t j = 0; j <= 16; ++j)
      for (uint32_t i = 0; i + j <= 16; ++i) {
        const dvec3& p = remeshed.positions[remeshed.lattice.vertex(face, i, j)];
        const double turn = std::atan2(p.y, p.x) / (2 * std::numbers::pi);
        const double expected = 256 * (turn < 0 ? turn + 1 : turn) - 0.5;
        const double found = filtered(*painted, painted->atlas.coordinates(face, dvec3(16 - i - j, i, j) / 16.0))[0];
        if (expected > 2 && expected < 253) { EXPECT_NEAR(found, expected, 1.5); }
      }
}

TEST(Paint, TintsMultiplyTheLightOfTextures) {
  Model patch = test::makePatch(4);
  patch.texture_coordinates.assign(patch.positions.size(), glm::dvec2(0.5));
  for (Corner& corner : patch.corners) corner.texture = corner.vertex;
  patch.materials.push_back({.name = "skin", .texture = "skin.png", .tint = {0.5, 1, 0, 0.5}});
  std::fill(patch.face_materials.begin(), patch.face_materials.end(), 0);
  const Textures textures{std::make_shared<const Image>(Image{1, 1, {{255, 200, 100, 255}}})};
  const Original original = makeOriginal(patch).value();
  const Remeshed remeshed = remesh(original, {.base_triangles = 8, .levels = 1, .attempts = 1}).value();
  const auto painted = paint({patch, textures}, original, remeshed, 4, 1);
  ASSERT_TRUE(painted.ok());
  const auto texel = painted->texels[painted->atlas.width() + 1];
  EXPECT_EQ(texel, 188u | 200u << 8 | 0u << 16 | 128u << 24);
}

TEST(Png, IsReadAsItWasWrittenAndDamageIsNamed) {
  const test::TemporaryFolder folder;
  std::vector<Colour> pixels;
  for (uint32_t i = 0; i < 35; ++i)
    pixels.push_back({static_cast<uint8_t>(7 * i), static_cast<uint8_t>(i), 3, static_cast<uint8_t>(255 - i)});
  png_image png{};
  png.version = PNG_IMAGE_VERSION, png.width = 7, png.height = 5, png.format = PNG_FORMAT_RGBA;
  const auto path = folder / "a.png";
  ASSERT_TRUE(png_image_write_to_file(&png, path.c_str(), 0, pixels.data(), 0, nullptr));
  const auto image = readPng(path);
  ASSERT_TRUE(image.ok()) << image.error().message;
  EXPECT_EQ(image->width, 7u);
  EXPECT_EQ(image->pixels, pixels);
  const auto bytes = test::slurp(path);
  for (size_t size = 0; size < bytes.size(); ++size) {
    test::spit(path, {bytes.begin(), bytes.begin() + static_cast<ptrdiff_t>(size)});
    if (const auto cut = readPng(path); !cut.ok())
      EXPECT_NE(cut.error().message.find("a.png"), std::string::npos);
    else
      EXPECT_GT(size, 60u);  // libpng shows what it has of an image whose end is missing
  }
  EXPECT_FALSE(readPng(folder / "missing.png").ok());
}

}  // namespace
}  // namespace foreland::terrain
