// glTF: the same mesh however it is written, and what is wrong is named.
#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <functional>
#include <glm/geometric.hpp>

#include "base/rng.h"
#include "terrain/model/read_model.h"
#include "tests/support/files.h"
#include "tests/support/gltf.h"
#include "tests/support/models.h"
#include "tests/support/seed.h"

namespace foreland::terrain {
namespace {

using glm::dvec3;
using test::GltfFile;
using test::Json;

const FileReader kNoFiles = [](const std::string& name) -> Result<Bytes> {
  return Error{ErrorCode::kNotFound, name + ": there is no such file"};
};

Result<Model> gltf(const std::string& text, const FileReader& files = kNoFiles) {
  const std::vector<uint8_t> exact(text.begin(), text.end());
  return parseGltf(exact, "m.glb", files);
}
Model read(const std::string& text, const FileReader& files = kNoFiles) {
  auto model = gltf(text, files);
  EXPECT_TRUE(model.ok()) << model.error().message;
  return model.ok() ? std::move(model).value() : Model();
}

std::vector<uint32_t> verticesOf(const Model& model) {
  std::vector<uint32_t> vertices;
  for (const Corner& corner : model.corners) vertices.push_back(corner.vertex);
  return vertices;
}
void expectSameMesh(const Model& found, const Model& expected) {
  EXPECT_EQ(found.positions, expected.positions);
  EXPECT_EQ(verticesOf(found), verticesOf(expected));
  EXPECT_EQ(found.face_ends, expected.face_ends);
}

// With coordinates that a float can hold.
Model makeTriangles() {
  Model model = test::inTriangles(test::makeTorus(9, 6));
  for (dvec3& p : model.positions) p = dvec3(glm::vec3(p));
  return model;
}

double volumeOf(const Model& model) {
  double volume = 0;
  for (size_t c = 0; c < model.corners.size(); c += 3) {
    const auto at = [&](size_t k) { return model.positions[model.corners[c + k].vertex]; };
    volume += glm::dot(at(0), glm::cross(at(1), at(2))) / 6;
  }
  return volume;
}

TEST(Gltf, IsTheSameMeshAsTheObj) {
  const Model torus = makeTriangles();
  const auto obj = parseObj(test::toObj(torus), "m.obj", kNoFiles);
  ASSERT_TRUE(obj.ok());
  const Model glb = read(test::toGltf(torus).toGlb());
  expectSameMesh(glb, *obj);
  EXPECT_EQ(glb.up, UpAxis::kY);
  EXPECT_EQ(obj->up, UpAxis::kZ);
}

TEST(Gltf, IsTheSameWhereverTheBufferIs) {
  const Model torus = makeTriangles();
  const GltfFile file = test::toGltf(torus);
  expectSameMesh(read(file.toText()), torus);
  const auto files = [&](const std::string& name) -> Result<Bytes> {
    EXPECT_EQ(name, "some data/mesh.bin");
    return file.buffer;
  };
  expectSameMesh(read(file.toText("./some%20data/mesh.bin"), files), torus);
  const test::TemporaryFolder folder;
  test::spit(folder / "mesh.bin", {file.buffer.begin(), file.buffer.end()});
  const std::string text = file.toText("mesh.bin");
  test::spit(folder / "m.gltf", {text.begin(), text.end()});
  const auto from_disk = readModel(folder / "m.gltf");
  ASSERT_TRUE(from_disk.ok()) << from_disk.error().message;
  expectSameMesh(*from_disk, torus);
}

TEST(Gltf, NodesMoveTurnAndScaleWhatTheyHold) {
  const Model sphere = test::makeSphere(1);
  GltfFile file = test::toGltf(sphere);
  const double half = std::sqrt(0.5);
  file.json["nodes"] = Json::array();
  file.append("nodes", {{"mesh", 0}, {"children", {1}}, {"translation", {10, 0, 0}}, {"scale", {2, 2, 2}}});
  // A quarter turn about z, then one further by the parent's units.
  file.append("nodes", {{"mesh", 0}, {"rotation", {0, 0, half, half}}, {"translation", {0, 1, 0}}});
  file.append("nodes", {{"mesh", 0}, {"matrix", {-3, 0, 0, 0, 0, 3, 0, 0, 0, 0, 3, 0, 0, 0, -9, 1}}});
  file.append("nodes", {{"mesh", 0}});  // in no scene
  file.json["scenes"][0]["nodes"] = {0, 2};
  const Model model = read(file.toGlb());
  const size_t count = sphere.positions.size();
  ASSERT_EQ(model.positions.size(), 3 * count);
  for (size_t v = 0; v < count; ++v) {
    const dvec3 p = dvec3(glm::vec3(sphere.positions[v]));
    EXPECT_LT(glm::distance(model.positions[v], 2.0 * p + dvec3(10, 0, 0)), 1e-12);
    EXPECT_LT(glm::distance(model.positions[count + v], 2.0 * dvec3(-p.y, p.x + 1, p.z) + dvec3(10, 0, 0)), 1e-12);
    EXPECT_LT(glm::distance(model.positions[2 * count + v], 3.0 * dvec3(-p.x, p.y, p.z) - dvec3(0, 0, 9)), 1e-12);
  }
  // The mirrored one still faces outward.
  EXPECT_NEAR(volumeOf(model), (8 + 8 + 27) * volumeOf(sphere), 1e-4);
}

TEST(Gltf, WithoutAScenePartsStandWhereTheirNodesSay) {
  GltfFile file = test::toGltf(test::makeSphere(0));
  file.json.erase("scenes");
  EXPECT_EQ(read(file.toGlb()).faceCount(), 8u);
  file.json.erase("nodes");
  EXPECT_EQ(read(file.toGlb()).faceCount(), 8u);
}

TEST(Gltf, StripsFansAndPlainListsAreTriangles) {
  // A square fan around vertex 0, and the strip of the same square.
  const Model square = test::makeModel({{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}}, {{0, 1, 2}, {0, 2, 3}});
  GltfFile file = test::toGltf(square);
  auto& primitive = file.json["meshes"][0]["primitives"][0];
  primitive["mode"] = 6;
  primitive.erase("indices");
  EXPECT_EQ(verticesOf(read(file.toGlb())), (std::vector<uint32_t>{0, 1, 2, 0, 2, 3}));
  primitive["mode"] = 5;
  primitive["indices"] = file.addAccessor(file.addView({0, 1, 3, 2}), 5121, "SCALAR", 4);
  EXPECT_EQ(verticesOf(read(file.toGlb())), (std::vector<uint32_t>{0, 1, 3, 1, 2, 3}));
  primitive["mode"] = 4;
  primitive["indices"] = file.addAccessor(file.addView(test::bytesOf<uint16_t>({0, 1, 2, 3, 0, 2})), 5123, "SCALAR", 6);
  EXPECT_EQ(verticesOf(read(file.toGlb())), (std::vector<uint32_t>{0, 1, 2, 3, 0, 2}));
  auto lines = primitive;
  lines["mode"] = 1;
  file.json["meshes"][0]["primitives"].push_back(lines);
  const Model model = read(file.toGlb());
  EXPECT_EQ(model.faceCount(), 2u);
  EXPECT_EQ(model.positions.size(), 4u);
  EXPECT_EQ(model.notes, std::vector<std::string>{"points or lines left out: 1"});
}

TEST(Gltf, PrimitivesOfTheSamePositionsShareVertices) {
  GltfFile file = test::toGltf(test::makeSphere(1));
  auto& primitives = file.json["meshes"][0]["primitives"];
  primitives.push_back(primitives[0]);
  primitives[0]["indices"] = file.addAccessor(1, 5125, "SCALAR", 48);
  file.json["accessors"].back()["byteOffset"] = 0;
  primitives[1]["indices"] = file.addAccessor(1, 5125, "SCALAR", 48);
  file.json["accessors"].back()["byteOffset"] = 48 * 4;
  expectSameMesh(read(file.toGlb()), [] {
    Model sphere = test::makeSphere(1);
    for (dvec3& p : sphere.positions) p = dvec3(glm::vec3(p));
    return sphere;
  }());
}

TEST(Gltf, AccessorsMayBeInterleavedShortSparseOrZero) {
  GltfFile file = test::toGltf(test::makeModel({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}, {{0, 1, 2}}));
  auto& attributes = file.json["meshes"][0]["primitives"][0]["attributes"];
  const std::vector<dvec3> expected{{0, 0, 0}, {1, 0, 0}, {0, 0.5, -1}};
  const auto positions = [&] { return read(file.toGlb()).positions; };

  std::vector<float> apart{9, 0, 0, 0, 9, 9, 1, 0, 0, 9, 9, 0, 0.5, -1, 9};
  attributes["POSITION"] = file.addAccessor(file.addView(test::bytesOf(apart), {{"byteStride", 20}}), 5126, "VEC3", 3);
  file.json["accessors"].back()["byteOffset"] = 4;
  EXPECT_EQ(positions(), expected);

  const std::vector<int8_t> shares{0, 0, 0, 0, 127, 0, 0, 0, 0, 0, -128, 0};
  attributes["POSITION"] = file.addAccessor(file.addView(test::bytesOf(shares), {{"byteStride", 4}}), 5120, "VEC3", 3);
  file.json["accessors"].back()["normalized"] = true;
  EXPECT_EQ(positions(), (std::vector<dvec3>{{0, 0, 0}, {1, 0, 0}, {0, 0, -1}}));

  attributes["POSITION"] = file.append(
      "accessors",
      {{"componentType", 5126},
       {"type", "VEC3"},
       {"count", 3},
       {"sparse",
        {{"count", 2},
         {"indices", {{"bufferView", file.addView({1, 2})}, {"componentType", 5121}}},
         {"values", {{"bufferView", file.addView(test::bytesOf(std::vector<float>{1, 0, 0, 0, 0.5, -1}))}}}}}});
  EXPECT_EQ(positions(), expected);
}

TEST(Gltf, ColoursOfVerticesAndMaterialsAreSrgb) {
  GltfFile file = test::toGltf(test::makeModel({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}, {{0, 1, 2}}));
  auto& primitive = file.json["meshes"][0]["primitives"][0];
  file.append("materials", {{"name", "paint"}, {"pbrMetallicRoughness", {{"baseColorFactor", {0.5, 1, 0, 0.25}}}}});
  primitive["material"] = 0;
  const Model painted = read(file.toGlb());
  EXPECT_EQ(painted.materials.at(0).name, "paint");
  EXPECT_EQ(painted.materials.at(0).colour, (Colour{188, 255, 0, 64}));
  EXPECT_EQ(painted.face_materials, std::vector<uint32_t>{0});
  EXPECT_TRUE(painted.colours.empty());
  primitive["attributes"]["COLOR_0"] = file.addAccessor(
      file.addView({255, 255, 255, 0, 0, 128, 255, 0, 0, 0, 0, 0}, {{"byteStride", 4}}), 5121, "VEC3", 3);
  file.json["accessors"].back()["normalized"] = true;
  EXPECT_EQ(read(file.toGlb()).colours, (std::vector<Colour>{{188, 255, 0, 64}, {0, 188, 0, 64}, {0, 0, 0, 64}}));
}

TEST(Gltf, TexturesAreFoundWhereverTheyAreAndCoordinatesAreTransformed) {
  GltfFile file = test::toGltf(test::makeModel({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}, {{0, 1, 2}}));
  auto& primitive = file.json["meshes"][0]["primitives"][0];
  primitive["attributes"]["TEXCOORD_1"] =
      file.addAccessor(file.addView(test::bytesOf(std::vector<float>{0, 0, 1, 0, 0.25, 0.5})), 5126, "VEC2", 3);
  const Bytes image{1, 2, 3, 4, 5};
  file.append("images", {{"bufferView", file.addView(image)}});
  file.append("images", {{"uri", "data:image/png;base64," + test::toBase64(image)}});
  file.append("images", {{"uri", "skins/a%2Bb.webp"}});
  for (int i = 0; i < 2; ++i) file.append("textures", {{"source", i}});
  file.append("textures", {{"source", 1}, {"extensions", {{"EXT_texture_webp", {{"source", 2}}}}}});
  for (int i = 0; i < 3; ++i)
    file.append("materials", {{"pbrMetallicRoughness", {{"baseColorTexture", {{"index", i}, {"texCoord", 1}}}}}});
  primitive["material"] = 0;
  const Model model = read(file.toGlb());
  for (size_t i = 0; i < 2; ++i) {
    ASSERT_TRUE(model.materials.at(i).embedded) << i;
    EXPECT_EQ(*model.materials[i].embedded, image);
  }
  EXPECT_FALSE(model.materials.at(2).embedded);
  EXPECT_EQ(model.materials[2].texture, "skins/a+b.webp");
  EXPECT_EQ(model.texture_coordinates, (std::vector<glm::dvec2>{{0, 1}, {1, 1}, {0.25, 0.5}}));
  EXPECT_EQ(model.corners[2].texture, 2u);

  file.json["materials"][0]["pbrMetallicRoughness"]["baseColorTexture"] = {
      {"index", 0},
      {"extensions", {{"KHR_texture_transform", {{"offset", {0.5, 0.125}}, {"scale", {2, 1}}, {"texCoord", 1}}}}}};
  EXPECT_EQ(read(file.toGlb()).texture_coordinates, (std::vector<glm::dvec2>{{0.5, 0.875}, {2.5, 0.875}, {1, 0.375}}));
}

TEST(Gltf, AnImageThatCannotBeFoundIsANote) {
  GltfFile file = test::toGltf(test::makeSphere(0));
  file.append("images", {{"uri", "../../../../../../etc/passwd"}});
  file.append("textures", {{"source", 0}});
  file.append("materials", {{"name", "skin"}, {"pbrMetallicRoughness", {{"baseColorTexture", {{"index", 0}}}}}});
  const test::TemporaryFolder folder;
  std::ofstream(folder / "m.glb", std::ios::binary) << file.toGlb();
  const auto found = readModel(folder / "m.glb");
  ASSERT_TRUE(found.ok()) << found.error().message;
  const Model& model = *found;
  EXPECT_TRUE(model.materials.at(0).texture.empty());
  ASSERT_EQ(model.notes.size(), 1u);
  EXPECT_NE(model.notes[0].find("without the texture of material 'skin'"), std::string::npos);
  EXPECT_NE(model.notes[0].find("outside of its folder"), std::string::npos);
}

TEST(Gltf, WhatIsPassedOverIsANote) {
  GltfFile file = test::toGltf(test::makeSphere(0));
  file.json["extensionsUsed"] = {"EXT_mesh_gpu_instancing", "KHR_texture_basisu", "KHR_materials_ior"};
  file.append("textures", {{"extensions", {{"KHR_texture_basisu", {{"source", 0}}}}}});
  const Json texture = {{"index", 0}};
  file.append("materials", {{"name", "skin"}, {"pbrMetallicRoughness", {{"baseColorTexture", texture}}}});
  file.append("materials",
              {{"extensions", {{"KHR_materials_pbrSpecularGlossiness", {{"diffuseFactor", {1, 0, 0, 1}}}}}}});
  file.json["nodes"][0]["skin"] = 0;
  file.json["nodes"][0]["translation"] = {1, 2, 3};
  const Model model = read(file.toGlb());
  EXPECT_EQ(model.notes,
            (std::vector<std::string>{
                "without the extension EXT_mesh_gpu_instancing, which is not supported",
                "without the texture of material 'skin': it has no PNG, JPEG or WebP image; export it with one",
                "skinned meshes taken as they rest: 1"}));
  EXPECT_EQ(model.materials.at(1).colour, (Colour{255, 0, 0, 255}));
  EXPECT_EQ(model.positions[0], dvec3(1, 0, 0));  // the skin's joints would place it
}

TEST(Gltf, WhatHasNoPlaceIsCounted) {
  GltfFile file = test::toGltf(test::makeSphere(0));
  const Json texture = {{"index", 0}};
  file.json["meshes"][0]["primitives"][0]["targets"] = Json::array({Json::object()});
  file.append("animations", Json::object()), file.append("animations", Json::object());
  file.append("materials", {{"normalTexture", texture},
                            {"emissiveTexture", texture},
                            {"pbrMetallicRoughness", {{"metallicRoughnessTexture", texture}}}});
  EXPECT_EQ(read(file.toGlb()).notes,
            (std::vector<std::string>{"animations left out: 2",
                                      "maps of materials (normal, gloss, glow, occlusion) left out: 3",
                                      "shapes that parts morph to left out: 1"}));
}

// Chunks should end at a multiple of four bytes.
TEST(Gltf, ChunksMayLackTheirPadding) {
  const Model expected = makeTriangles();
  GltfFile file = test::toGltf(expected);
  for (int extra = 0; extra < 4; ++extra) {
    file.json["asset"]["generator"] = std::string(static_cast<size_t>(extra), 'x');
    expectSameMesh(read(file.toGlb(test::GltfPadding::kNone)), expected);
    expectSameMesh(read(file.toGlb()), expected);
  }
}

TEST(Gltf, TextMayHaveAMark) {
  const Model expected = makeTriangles();
  expectSameMesh(read("\xef\xbb\xbf" + test::toGltf(expected).toText()), expected);
}

TEST(Gltf, RefusesKhronosMeshoptByNameWithAWayOut) {
  GltfFile file = test::toGltf(test::makeSphere(0));
  const std::string way_out = "pack it with EXT_meshopt_compression (gltfpack -c), or not at all";
  file.json["extensionsUsed"] = {"KHR_meshopt_compression"};
  file.json["bufferViews"][0]["buffer"] = 1;  // as files that hold the unpacked bytes nowhere
  Json whole = Json::parse(file.toText());
  whole["buffers"].push_back({{"byteLength", file.buffer.size()}});
  const auto used = gltf(whole.dump());
  ASSERT_FALSE(used.ok());
  EXPECT_NE(used.error().message.find("KHR_meshopt_compression"), std::string::npos) << used.error().message;
  EXPECT_NE(used.error().message.find(way_out), std::string::npos) << used.error().message;
  file.json["extensionsRequired"] = {"KHR_meshopt_compression"};
  const auto required = gltf(file.toText());
  ASSERT_FALSE(required.ok());
  EXPECT_NE(required.error().message.find("KHR_meshopt_compression"), std::string::npos) << required.error().message;
  EXPECT_NE(required.error().message.find(way_out), std::string::npos) << required.error().message;
}

struct Wrong {
  std::function<void(GltfFile&)> change;
  std::string words;
};

TEST(Gltf, NamesWhatIsWrong) {
  const std::vector<Wrong> wrongs{
      {[](GltfFile& f) { f.json["asset"]["version"] = "1.0"; }, "version '1.0'; export it as glTF 2.0"},
      {[](GltfFile& f) { f.json["extensionsRequired"] = {"ACME_shapes"}; }, "requires the extension \"ACME_shapes\""},
      {[](GltfFile& f) { f.json["meshes"] = 7; }, "meshes is no array"},
      {[](GltfFile& f) { f.json["meshes"][0] = "x"; }, "meshes[0] is no object"},
      {[](GltfFile& f) { f.json["accessors"][0]["count"] = -1; }, "accessors[0].count is no whole number"},
      {[](GltfFile& f) { f.json["accessors"][0]["count"] = 1e300; }, "accessors[0].count is no whole number"},
      {[](GltfFile& f) { f.json["accessors"][0]["count"] = 1000; }, "accessors[0] has more elements than its view"},
      {[](GltfFile& f) { f.json["accessors"][0]["count"] = 7; },
       "accessors[0] reaches beyond the end of bufferViews[0]"},
      {[](GltfFile& f) { f.json["accessors"][0]["byteOffset"] = 4; }, "accessors[0] reaches beyond the end"},
      {[](GltfFile& f) { f.json["accessors"][0]["byteOffset"] = uint64_t{1} << 63; }, "accessors[0].byteOffset"},
      {[](GltfFile& f) { f.json["accessors"][0]["bufferView"] = 9; }, "accessors[0].bufferView names one of 2"},
      {[](GltfFile& f) { f.json["accessors"][0]["componentType"] = 1; }, "accessors[0].componentType is 1"},
      {[](GltfFile& f) { f.json["accessors"][0]["type"] = "VEC9"; }, "accessors[0].type is no type"},
      {[](GltfFile& f) { f.json["accessors"][0]["type"] = "VEC2"; }, "POSITION has 2 components instead of 3"},
      {[](GltfFile& f) { f.json["accessors"][1]["componentType"] = 5126; }, "accessors[1] is used as indices"},
      {[](GltfFile& f) { f.json["accessors"][1]["count"] = 23; }, "has 23 corners, which are no triangles"},
      {[](GltfFile& f) { f.json["accessors"][0].erase("bufferView"), f.json["accessors"][0]["count"] = 100000000; },
       "has more than 1048576 elements, but no data"},
      {[](GltfFile& f) { f.json["accessors"][0]["count"] = 5; },
       "meshes[0].primitives[0] names vertex 5, but there are only 5"},
      {[](GltfFile& f) { f.json["bufferViews"][0]["byteLength"] = 1u << 30; }, "beyond the end of buffers[0]"},
      {[](GltfFile& f) { f.json["bufferViews"][0]["buffer"] = 1; }, "bufferViews[0].buffer names one of 1"},
      {[](GltfFile& f) { f.json["bufferViews"][0].erase("buffer"); }, "bufferViews[0].buffer is missing"},
      {[](GltfFile& f) { f.json["meshes"][0]["primitives"][0]["attributes"].erase("POSITION"); }, "has no positions"},
      {[](GltfFile& f) { f.json["nodes"][0]["children"] = {0}; }, "nodes[0] is a child, but also a scene's root"},
      {[](GltfFile& f) {
         f.json["nodes"] = {{{"children", {1}}}, {{"children", {1}}}};
       },
       "nodes[1] is a child of several"},
      {[](GltfFile& f) { f.json["nodes"][0]["children"] = {5}; }, "nodes[0].children names one of 1"},
      {[](GltfFile& f) {
         f.json["nodes"][0]["scale"] = {1, 1};
       },
       "nodes[0].scale does not have 3 numbers"},
      {[](GltfFile& f) {
         f.json["nodes"][0]["scale"] = {1e30, 1, 1};
       },
       "vertex 0 has a coordinate beyond 1e9"},
      {[](GltfFile& f) { f.json["scenes"][0]["nodes"] = Json::array(); }, "has no face"},
      {[](GltfFile& f) { f.buffer[2] = 0xc0, f.buffer[3] = 0x7f; },
       "vertex 0 has a coordinate that is no finite number"},
  };
  for (const Wrong& wrong : wrongs) {
    GltfFile file = test::toGltf(test::makeSphere(0));
    wrong.change(file);
    const auto model = gltf(file.toGlb());
    ASSERT_FALSE(model.ok()) << wrong.words;
    EXPECT_TRUE(model.error().message.starts_with("m.glb: ")) << model.error().message;
    EXPECT_NE(model.error().message.find(wrong.words), std::string::npos) << model.error().message;
  }
}

std::string word(uint32_t value) {
  std::string out;
  for (int i = 0; i < 4; ++i) out += static_cast<char>(value >> (8 * i) & 0xff);
  return out;
}

// Containers whose lengths, padding and further chunks are not as they should be hold the same model.
TEST(Gltf, ReadsOddContainers) {
  const Model sphere = test::makeSphere(0);
  const std::string glb = test::toGltf(sphere).toGlb();
  const auto notesOf = [&](const std::string& bytes) {
    const auto model = gltf(bytes);
    EXPECT_TRUE(model.ok()) << model.error().message;
    if (!model.ok()) return std::vector<std::string>{model.error().message};
    EXPECT_EQ(model->faceCount(), sphere.faceCount());
    return model->notes;
  };
  using Notes = std::vector<std::string>;
  const auto withLength = [&](std::string bytes, size_t length) {
    return bytes.replace(8, 4, word(static_cast<uint32_t>(length)));
  };
  const std::string size = std::to_string(glb.size());
  EXPECT_EQ(notesOf(glb), Notes());
  EXPECT_EQ(notesOf(withLength(glb, 0)), Notes{"says that it has 0 bytes, but has " + size});
  EXPECT_EQ(notesOf(withLength(glb, glb.size() + 4)),
            Notes{"says that it has " + std::to_string(glb.size() + 4) + " bytes, but has " + size});
  const std::string extra = word(4) + "XTRA" + "abcd";
  EXPECT_EQ(notesOf(withLength(glb + extra, glb.size() + 12)), Notes{"chunks of other kinds left out: 1"});
  EXPECT_EQ(notesOf(withLength(glb + "junk!", glb.size() + 5)), Notes{"bytes behind the last chunk left out: 5"});
  EXPECT_EQ(notesOf(withLength(glb + std::string(4, '\0'), glb.size() + 4)), Notes());
  // Zeros instead of blanks behind the JSON.
  const size_t json_end = glb.find(std::string("BIN\0", 4)) - 4;
  std::string zeros = glb.substr(0, json_end) + std::string(4, '\0') + glb.substr(json_end);
  zeros.replace(12, 4, word(static_cast<uint32_t>(json_end - 20 + 4)));
  EXPECT_EQ(notesOf(withLength(zeros, zeros.size())), Notes());
  const auto cut = gltf(glb.substr(0, glb.size() - 8));
  ASSERT_FALSE(cut.ok());
  EXPECT_NE(cut.error().message.find("cut short"), std::string::npos) << cut.error().message;
}

TEST(Gltf, RefusesFilesOutsideItsFolderAndBrokenContainers) {
  const GltfFile file = test::toGltf(test::makeSphere(0));
  const test::TemporaryFolder folder;
  for (const char* uri : {"../mesh.bin", "/etc/passwd", "a/../../b.bin", "file:///etc/passwd", "http://a/b.bin",
                          "%2e%2e/mesh.bin", "..\\mesh.bin", "C:\\mesh.bin"}) {
    std::ofstream(folder / "m.gltf") << file.toText(uri);
    const auto model = readModel(folder / "m.gltf");
    ASSERT_FALSE(model.ok()) << uri;
    EXPECT_NE(model.error().message.find("of its folder"), std::string::npos) << model.error().message;
  }
  const auto words = [](const std::string& text) {
    const auto model = gltf(text);
    return model.ok() ? std::string("a model") : model.error().message;
  };
  EXPECT_NE(words(file.toText("gone.bin")).find("gone.bin: there is no such file"), std::string::npos);
  EXPECT_NE(words(file.toText("data:;base64,AAAA")).find("buffers[0] promises 168 bytes, but has 3"), std::string::npos)
      << words(file.toText("data:;base64,AAAA"));
  EXPECT_NE(words(file.toText("data:;base64,A*A")).find("no base64"), std::string::npos);
  EXPECT_NE(words(file.toText("data:,abc")).find("not in base64"), std::string::npos);
  EXPECT_NE(words("").find("its JSON is broken"), std::string::npos);
  EXPECT_NE(words("[]").find("its JSON is broken"), std::string::npos);
  std::string glb = file.toGlb();
  EXPECT_NE(words(glb.substr(0, 40)).find("cut short"), std::string::npos);
  glb[4] = 1;
  EXPECT_NE(words(glb).find("version 1; export it as glTF 2.0"), std::string::npos);
  const std::string deep =
      "{\"asset\":{\"version\":\"2.0\"},\"extras\":" + std::string(100000, '[') + std::string(100000, ']') + "}";
  EXPECT_NE(words(deep).find("has no face"), std::string::npos);
}

}  // namespace
}  // namespace foreland::terrain
