// Reference pictures: their depth against every triangle tried, sections against the full resolution, error images
// against the tolerance, and their files as others read them.
#include "terrain/render/picture.h"

#include <OpenEXR/ImfChannelList.h>
#include <OpenEXR/ImfHeader.h>
#include <OpenEXR/ImfInputFile.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <fstream>
#include <glm/geometric.hpp>
#include <set>

#include "apps/exact_sections.h"
#include "oracle/drawn_surface.h"
#include "terrain/render/exr.h"
#include "terrain/render/screen_image.h"
#include "tests/support/exr_channel.h"
#include "tests/support/scene.h"
#include "tests/support/surface_file.h"

namespace foreland::test {
namespace {

using terrain::Camera;
using terrain::Picture;
using terrain::RayCaster;

const proto::Lens kLens{.vertical_fov_rad = 0.9, .width_px = 160, .height_px = 120};

// Over the south of the data, looking north and a little down.
Camera overTheSouth(const terrain::Scene& scene) {
  const proto::FrameTransform transform(scene.frame());
  const proto::GridShape& shape = scene.grid().shape();
  const glm::dvec3 eye = transform.toScene(proto::LatticePosition{0.5 * shape.samples_x, 0.1 * shape.samples_y, 1500});
  return {{eye, proto::lookAlong(glm::normalize(glm::dvec3(0.1, 1, -0.6)), {0, 0, 1})}, kLens};
}

struct Truth {
  std::shared_ptr<const terrain::Scene> scene;
  RayCaster caster;
  terrain::Shading shading;

  explicit Truth(const std::shared_ptr<const terrain::Scene>& of)
      : scene(of), caster(RayCaster::ofScene(of).value()), shading(terrain::Shading::of(of).value()) {}
  Picture take(const Camera& camera) const { return terrain::takePicture(caster, scene->grid(), shading, camera); }

  terrain::DrawnSurface sectionFor(const Camera& camera, double tau_px) const {
    const auto section_at = apps::exactSections(scene, server::objectsOf(scene).value());
    return oracle::drawnSurface(*section_at({.pose = camera.pose, .lens = camera.lens, .tau_px = tau_px}), 1);
  }
  terrain::PixelErrors errorsAt(const Camera& camera, double tau_px) const {
    return terrain::measureErrors(caster, *terrain::ParameterLookup::of(sectionFor(camera, tau_px)), camera);
  }
};

// A plane's depth at pixel (i, j) in closed form, from the definition of the camera (proto/space/pose.h).
TEST(Picture, HasAPlanesOwnDepthAndNormal) {
  const Truth truth(makeScene(257, 257, [](uint32_t, uint32_t) { return 250.0; }));
  const Camera camera{{{0, 0, 650}, proto::lookAlong({0, 0, -1}, {0, 1, 0})}, kLens};
  const Picture picture = truth.take(camera);
  for (size_t i = 0; i < picture.depth_m.size(); ++i) {
    EXPECT_FLOAT_EQ(picture.depth_m[i], 400) << i;
    EXPECT_EQ(picture.normal[i], glm::vec3(0, 0, 1)) << i;
    EXPECT_EQ(picture.object[i], 0u);
  }
  // Pixel (100, 40) is 20.5 pixels to the right of the middle and 19.5 above it, 400 m away; a sample is 10 m.
  const double metres = 400 / kLens.focalPx();
  const auto x = static_cast<uint32_t>(std::lround(128 + 20.5 * metres / 10)),
             y = static_cast<uint32_t>(std::lround(128 + 19.5 * metres / 10));
  EXPECT_EQ(picture.node[40 * kLens.width_px + 100], truth.scene->grid().slot(proto::NodeId::at(x, y)));
}

// March along each ray in steps of half a metre; where it dips below the ground, by the height between the cell's
// corners, halve. The cell's height is bilinear here, which differs from two triangles by a quarter of its twist.
TEST(Picture, AgreesWithAMarchedHeightField) {
  const auto smooth = [](uint32_t x, uint32_t y) { return 300 + 80 * std::sin(0.05 * x) * std::cos(0.04 * y); };
  const Truth truth(makeScene(257, 257, smooth));
  const Camera camera{{{30, -1000, 600}, proto::lookAlong(glm::normalize(glm::dvec3(0.1, 1, -0.4)), {0, 0, 1})}, kLens};
  const Picture picture = truth.take(camera);
  const auto ground = [&](const glm::dvec3& p) {
    const double x = p.x / 10 + 128, y = p.y / 10 + 128;
    return x < 0 || y < 0 || x > 256 || y > 256 ? -1e9 : 300 + 80 * std::sin(0.05 * x) * std::cos(0.04 * y);
  };
  size_t compared = 0;
  for (uint32_t row = 7; row < kLens.height_px; row += 7)
    for (uint32_t column = 5; column < kLens.width_px; column += 9) {
      const glm::dvec3 direction =
          glm::normalize(camera.pose.forward() + (column + 0.5 - 80) / kLens.focalPx() * camera.pose.right() +
                         (60 - row - 0.5) / kLens.focalPx() * camera.pose.up());
      double t = 0;
      while (t < 5000 && (camera.pose.eye + t * direction).z > ground(camera.pose.eye + t * direction)) t += 0.5;
      const float depth = picture.depth_m[row * kLens.width_px + column];
      const glm::dvec3 met = camera.pose.eye + t * direction;
      if (met.z > ground(met) || ground(met) < 0 || ground(met + direction) < 0) continue;  // sky, or a border
      ++compared;
      // Half a step, a tenth of a metre's rounding of heights and the curvature over a cell, along a slanting ray.
      EXPECT_NEAR(depth, t * glm::dot(direction, camera.pose.forward()), 1.5) << row << " " << column;
    }
  EXPECT_GT(compared, 50u);
}

class PictureFrames : public testing::TestWithParam<proto::FrameKind> {};

TEST_P(PictureFrames, OfASectionWithoutToleranceIsTheFullOne) {
  const Truth truth(makeScene(150, 131, hills(21), GetParam()));
  const Camera camera = overTheSouth(*truth.scene);
  const auto drawn = RayCaster::ofSurface(truth.sectionFor(camera, 1e-9));
  ASSERT_TRUE(drawn.ok());
  const Picture full = truth.take(camera),
                section = terrain::takePicture(*drawn, truth.scene->grid(), truth.shading, camera);
  size_t seen = 0, different = 0;
  for (size_t i = 0; i < full.depth_m.size(); ++i) {
    seen += std::isfinite(full.depth_m[i]);
    different += std::isfinite(full.depth_m[i]) != std::isfinite(section.depth_m[i]) ||
                 std::fabs(full.depth_m[i] - section.depth_m[i]) > 1e-5 * full.depth_m[i];
  }
  EXPECT_GT(seen, full.depth_m.size() / 3);
  EXPECT_LE(different, seen / 1000) << "of " << seen;  // at silhouettes
  const auto summary = terrain::summarise(truth.errorsAt(camera, 1e-9), 0.01);
  EXPECT_EQ(summary.terrain_pixels, seen);
  EXPECT_LT(summary.terrain_max_px, 1e-3);
}

TEST_P(PictureFrames, ErrorsOfASectionStayWithinItsTolerance) {
  const Truth truth(makeScene(150, 131, hills(22), GetParam()));
  const Camera camera = overTheSouth(*truth.scene);
  for (const double tau_px : {0.5, 2.0, 8.0}) {
    const auto summary = terrain::summarise(truth.errorsAt(camera, tau_px), tau_px);
    EXPECT_EQ(summary.terrain_over_tau, 0u) << tau_px << ": " << summary.terrain_max_px;
    EXPECT_GT(summary.terrain_max_px, 0.3 * tau_px);
  }
}

INSTANTIATE_TEST_SUITE_P(Both, PictureFrames,
                         testing::Values(proto::FrameKind::kPlanar, proto::FrameKind::kGeographic));

terrain::PixelErrors errorsOf(const Truth& truth, const terrain::DrawnSurface& drawn, const Camera& camera) {
  return terrain::measureErrors(truth.caster, *terrain::ParameterLookup::of(drawn), camera);
}

TEST(ErrorImage, IsTheDistanceBetweenCounterparts) {
  const Truth truth(makeScene(257, 257, [](uint32_t, uint32_t) { return 250.0; }));
  const Camera camera{{{0, 0, 650}, proto::lookAlong({0, 0, -1}, {0, 1, 0})}, kLens};
  terrain::DrawnSurface drawn = truth.sectionFor(camera, 1);
  for (glm::vec3& p : drawn.terrain.positions) p.x += 3;
  const double shift_px = 3 * kLens.focalPx() / 400;
  for (const float px : errorsOf(truth, drawn, camera).px) ASSERT_NEAR(px, shift_px, 1e-3);
  drawn.terrain.indices.clear();
  for (const float px : errorsOf(truth, drawn, camera).px)
    ASSERT_EQ(px, std::numeric_limits<float>::infinity()) << "what is not drawn is as wrong as can be";
}

TEST(ErrorImage, IsYellowAtTheToleranceRedAboveAndGreyInTheSky) {
  Picture picture;
  picture.width = 3;
  picture.height = 1;
  picture.colour.resize(3);
  picture.error_px = {2.0f, 2.2f, std::nanf("")};
  const terrain::Image image = terrain::errorImage(picture, 2);
  EXPECT_GT(image.at(0, 0)[1], 200);  // green makes red yellow
  EXPECT_LT(image.at(1, 0)[1], 100);
  EXPECT_GT(image.at(1, 0)[0], 200);
  EXPECT_EQ(image.at(2, 0)[0], image.at(2, 0)[2]);
  const auto summary = terrain::summarise({picture.error_px, {0, 0, terrain::kNothing}}, 2);
  EXPECT_EQ(summary.terrain_pixels, 2u);
  EXPECT_EQ(summary.terrain_over_tau, 1u);
}

// A sphere whose image is red, on the ground before the eye.
std::shared_ptr<const terrain::Scene> sceneWithARedSphere() {
  const TemporaryFolder folder;
  const std::string model = folder / "red.fls", path = folder / "land.fls";
  const terrain::TrueSurface sphere = *terrain::makeSphere(2, {proto::MeshRule::kQuadrisection, 4, 1e-3});
  const auto records = terrain::computeBounds(sphere, {.threads = 1});
  const auto atlas = proto::AtlasLayout::of(sphere.topology.base().faceCount(), 8);
  const std::vector<terrain::Texel> texels(uint64_t{atlas.width()} * atlas.height(), 0xff0000ff);
  EXPECT_TRUE(
      terrain::writeSurface(
          model, {.surface = sphere, .records = records, .atlas = atlas, .texels = texels, .about = {"red", {}, {}}})
          .ok());
  FormulaSource source(33, 33, [](uint32_t, uint32_t) { return 0.0; });
  EXPECT_TRUE(
      terrain::buildScene(
          source, {.output = path, .height_quantum_m = 0.1, .additions = {.objects = {{model, {0, 0}, 0, 0, 5}}}})
          .ok());
  return *terrain::Scene::open(path);
}

TEST(Picture, ShowsObjectsInTheirColoursAndMeasuresThemByTheirParameters) {
  const Truth truth(sceneWithARedSphere());
  const Camera camera{{{0, -60, 10}, proto::lookAlong({0, 1, 0}, {0, 0, 1})}, kLens};
  const size_t middle = kLens.width_px * kLens.height_px / 2 + kLens.width_px / 2;
  const Picture picture = truth.take(camera);
  EXPECT_EQ(picture.object[middle], 1u);
  EXPECT_EQ(picture.node[middle], terrain::kNothing);
  EXPECT_NEAR(picture.depth_m[middle], 50, 0.1);
  EXPECT_GT(picture.colour[middle].r, 1.5f * picture.colour[middle].b);
  for (const double tau_px : {0.5, 3.0}) {
    const terrain::PixelErrors errors = truth.errorsAt(camera, tau_px);
    EXPECT_FALSE(std::isnan(errors.px[middle]));
    EXPECT_GT(terrain::summarise(errors, tau_px).objects_max_px, 0);
    EXPECT_LE(terrain::summarise(errors, tau_px).objects_max_px, 7 * tau_px);
  }
}

TEST(Exr, IsReadBackByTheNamesOfItsLayers) {
  const Truth truth(makeScene(65, 65, hills(9)));
  const Camera camera = overTheSouth(*truth.scene);
  Picture picture = truth.take(camera);
  picture.error_px = truth.errorsAt(camera, 1).px;
  const auto bytes = terrain::encodeExr(picture.width, picture.height, terrain::channelsOf(picture));
  ASSERT_TRUE(bytes.ok());
  const TemporaryFolder folder;
  const auto path = folder / "picture.exr";
  std::ofstream(path, std::ios::binary).write(reinterpret_cast<const char*>(bytes->data()), std::ssize(*bytes));
  const auto sameBits = [&](const char* name, const auto& expected) {
    const std::vector<float> values = readChannel(path, name);
    ASSERT_EQ(values.size(), expected.size()) << name;
    EXPECT_EQ(std::memcmp(values.data(), expected.data(), 4 * values.size()), 0) << name;
  };
  sameBits("depth.Z", picture.depth_m);
  sameBits("id.node", picture.node);
  sameBits("id.object", picture.object);
  sameBits("error.px", picture.error_px);
  const std::vector<float> green = readChannel(path, "G"), north = readChannel(path, "normal.Y");
  for (size_t i = 0; i < green.size(); ++i) {
    ASSERT_EQ(green[i], picture.colour[i].g);
    ASSERT_EQ(north[i], picture.normal[i].y);
  }
  std::set<std::string> layers;
  Imf::InputFile(path.c_str()).header().channels().layers(layers);
  EXPECT_EQ(layers, (std::set<std::string>{"depth", "error", "id", "normal"}));
}

TEST(Png, IsReadBackAsItWas) {
  terrain::Image image{5, 3, {}};
  for (uint8_t i = 0; i < 15; ++i) image.pixels.push_back({i, static_cast<uint8_t>(200 - i), 7, 255});
  const auto bytes = terrain::encodePng(image);
  ASSERT_TRUE(bytes.ok());
  const TemporaryFolder folder;
  std::ofstream(folder / "a.png", std::ios::binary)
      .write(reinterpret_cast<const char*>(bytes->data()), std::ssize(*bytes));
  const auto read = terrain::readPng(folder / "a.png");
  ASSERT_TRUE(read.ok()) << read.error().message;
  EXPECT_EQ(read->width, 5u);
  EXPECT_EQ(read->pixels, image.pixels);
}

}  // namespace
}  // namespace foreland::test
