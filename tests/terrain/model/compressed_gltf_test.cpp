// Compressed glTF: the mesh within its quantisation, and what is damaged is named.
#include "tests/support/compressed_gltf.h"
#include "tests/support/damage.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <tuple>

#include "base/rng.h"
#include "terrain/model/read_model.h"
#include "tests/support/models.h"
#include "tests/support/seed.h"

namespace foreland::terrain {
namespace {

using glm::dvec3;
using Triangle = std::array<dvec3, 3>;

Result<Model> glb(const std::string& text) {
  const std::vector<uint8_t> exact(text.begin(), text.end());
  return parseGltf(exact, "m.glb", [](const std::string& name) -> Result<Bytes> {
    return Error{ErrorCode::kNotFound, name};
  });
}

// Each triangle from its first corner in space, all in the order of their centres.
std::vector<Triangle> trianglesOf(const Model& model) {
  std::vector<Triangle> triangles;
  const auto key = [](const dvec3& p) {  // far coarser than any quantum here, far finer than the mesh
    return std::tuple(std::lround(p.x * 500), std::lround(p.y * 500), std::lround(p.z * 500));
  };
  for (size_t c = 0; c < model.corners.size(); c += 3) {
    Triangle t;
    for (size_t k = 0; k < 3; ++k) t[k] = model.positions[model.corners[c + k].vertex];
    std::rotate(t.begin(), std::min_element(t.begin(), t.end(), [&](auto& a, auto& b) { return key(a) < key(b); }),
                t.end());
    triangles.push_back(t);
  }
  std::sort(triangles.begin(), triangles.end(), [&](const Triangle& a, const Triangle& b) {
    return std::tuple(key(a[0]), key(a[1]), key(a[2])) < std::tuple(key(b[0]), key(b[1]), key(b[2]));
  });
  return triangles;
}

// Vertices on a grid of 1/50, slightly off it, so that their order survives quantisation.
Model makeGridded() {
  Model model = test::inTriangles(test::makeTorus(12, 8));
  for (dvec3& p : model.positions)
    for (int axis = 0; axis < 3; ++axis) p[axis] = (std::lround(p[axis] * 50) + 0.2) / 50;
  return model;
}

void expectWithin(const std::string& bytes, const Model& expected, double quantum) {
  const auto model = glb(bytes);
  ASSERT_TRUE(model.ok()) << model.error().message;
  const auto found = trianglesOf(*model), wanted = trianglesOf(expected);
  ASSERT_EQ(found.size(), wanted.size());
  for (size_t t = 0; t < wanted.size(); ++t)
    for (size_t k = 0; k < 3; ++k)
      for (int axis = 0; axis < 3; ++axis) ASSERT_NEAR(found[t][k][axis], wanted[t][k][axis], quantum);
}

TEST(CompressedGltf, DracoIsTheMeshWithinItsQuantisation) {
  // The largest side of the box is 2.8: half a step of 2^14 - 1, and the rounding of floats.
  expectWithin(test::toDracoGltf(makeGridded(), 14).toGlb(), makeGridded(), 2.8 / 16383 / 2 + 1e-6);
}

TEST(CompressedGltf, MeshoptIsTheMeshWithinItsQuantisation) {
  expectWithin(test::toMeshoptGltf(makeGridded()).toGlb(), makeGridded(), 2.0 / 32767 / 2 + 1e-6);
}

TEST(CompressedGltf, NamesWhatIsWrong) {
  const auto words = [](const test::GltfFile& file) {
    const auto model = glb(file.toGlb());
    return model.ok() ? std::string("a model") : model.error().message;
  };
  const auto expect = [&](const test::GltfFile& file, const char* part) {
    EXPECT_NE(words(file).find(part), std::string::npos) << words(file);
  };
  const test::GltfFile draco = test::toDracoGltf(test::makeSphere(1), 10),
                       meshopt = test::toMeshoptGltf(test::makeSphere(1));
  test::GltfFile file = draco;
  file.buffer[0] = 'X';
  expect(file, "m.glb: meshes[0].primitives[0] has Draco data that is damaged");
  file = draco;
  file.json["meshes"][0]["primitives"][0]["extensions"]["KHR_draco_mesh_compression"]["attributes"]["POSITION"] = 77;
  expect(file, "without its attribute POSITION");
  file = meshopt;
  auto& packed = file.json["bufferViews"][0]["extensions"]["EXT_meshopt_compression"];
  file.buffer[0] = 0;
  expect(file, "has meshopt data that is damaged; export the model again");
  file.buffer = meshopt.buffer;
  packed["count"] = 1u << 28;
  expect(file, "more than its bytes can hold");
  packed["count"] = 18, packed["byteStride"] = 7;
  expect(file, "which do not go together");
  packed["byteStride"] = 8, packed["mode"] = "ZIP";
  expect(file, "unknown mode 'ZIP'");
  packed["mode"] = "ATTRIBUTES", packed["filter"] = "BLUR";
  expect(file, "which do not go together");
}

TEST(CompressedGltf, DamagedFilesEndInAModelOrAnError) {
  const uint64_t seed = test::randomSeed();
  SCOPED_TRACE(seed);
  Rng rng(seed);
  const std::vector<std::string> files{
      test::toDracoGltf(test::makeSphere(1), 10).toGlb(), test::toMeshoptGltf(test::makeSphere(1)).toGlb(),
      test::toGltf(test::makeSphere(1)).toGlb(), test::toGltf(test::makeSphere(1)).toText()};
  const int refused = test::countRefused(files, 4000, 8, rng, [](const std::string& bytes) { return glb(bytes); });
  EXPECT_GT(refused, 500);
  EXPECT_LT(refused, 4000);
}

}  // namespace
}  // namespace foreland::terrain
