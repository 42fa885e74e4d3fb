// Reads any bytes as glTF, plain or compressed, and repairs what was read. The result must be a Model whose indices are
// in range, or an Error; the repaired one a manifold, or an Error. The input:
//
//   1 byte       255: the rest is the whole file. Otherwise the number of a sound file, modulo how many there are
//   changes      offset (2, little-endian, modulo the file's size), count (1), then count % 8 + 1 bytes that replace those
//
// A file that it names beside it is the rest of the input, too.
#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "base/check.h"
#include "terrain/model/read_model.h"
#include "terrain/remesh/original/original.h"
#include "tests/support/compressed_gltf.h"
#include "tests/support/models.h"

namespace {

using namespace foreland;

// Every kind of data, in a few hundred bytes.
std::vector<std::string> makeSoundFiles() {
  const terrain::Model sphere = test::makeSphere(0);
  test::GltfFile painted = test::toGltf(sphere);
  auto& primitive = painted.json["meshes"][0]["primitives"][0];
  primitive["attributes"]["TEXCOORD_0"] =
      painted.addAccessor(painted.addView(Bytes(48, 64), {{"byteStride", 8}}), 5126, "VEC2", 6);
  primitive["attributes"]["COLOR_0"] = painted.addAccessor(painted.addView(Bytes(24, 200)), 5121, "VEC4", 6);
  primitive["material"] = 0;
  painted.append("images", {{"bufferView", painted.addView({1, 2, 3})}});
  painted.append("textures", {{"source", 0}});
  painted.append("materials", {{"pbrMetallicRoughness", {{"baseColorTexture", {{"index", 0}}}}}});
  painted.append("nodes", {{"children", {0}}, {"rotation", {0, 0, 0, 1}}, {"scale", {1, -2, 3}}});
  painted.json["scenes"][0]["nodes"] = {1};
  painted.json["accessors"][0]["sparse"] = {
      {"count", 1}, {"indices", {{"bufferView", 1}, {"componentType", 5125}}}, {"values", {{"bufferView", 0}}}};
  return {test::toGltf(sphere).toGlb(),
          test::toDracoGltf(sphere, 8).toGlb(),
          test::toMeshoptGltf(sphere).toGlb(),
          painted.toGlb(),
          painted.toText(),
          painted.toText("beside.bin")};
}

Bytes fileOf(ByteSpan input) {
  static const std::vector<std::string> files = makeSoundFiles();
  if (input[0] == 255) return {input.begin() + 1, input.end()};
  const std::string& sound = files[input[0] % files.size()];
  Bytes bytes(sound.begin(), sound.end());
  for (ByteSpan rest = input.subspan(1); rest.size() > 3;) {
    const size_t offset = rest[0] | size_t{rest[1]} << 8, count = std::min<size_t>(rest[2] % 8 + 1, rest.size() - 3);
    for (size_t i = 0; i < count; ++i) bytes[(offset + i) % bytes.size()] = rest[3 + i];
    rest = rest.subspan(3 + count);
  }
  return bytes;
}

void check(const terrain::Model& model) {
  CHECK_EQ(model.face_materials.size(), model.faceCount());
  CHECK_TRUE(model.colours.empty() || model.colours.size() == model.positions.size());
  for (const glm::dvec3& p : model.positions)
    for (int axis = 0; axis < 3; ++axis) CHECK_LE(std::fabs(p[axis]), terrain::kMaxCoordinate);
  for (const terrain::Corner& corner : model.corners) {
    CHECK_LT(corner.vertex, model.positions.size());
    CHECK_TRUE(corner.texture == terrain::kNoIndex || corner.texture < model.texture_coordinates.size());
  }
  for (const uint32_t material : model.face_materials)
    CHECK_TRUE(material == terrain::kNoIndex || material < model.materials.size());
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  if (size == 0) return 0;
  const auto beside = [&](const std::string&) -> Result<Bytes> { return Bytes(data + 1, data + size); };
  const auto model = terrain::parseGltf(fileOf({data, size}), "model", beside);
  if (!model.ok()) {
    CHECK_TRUE(model.error().message.starts_with("model: "));
    return 0;
  }
  check(*model);
  if (model->faceCount() > 1000) return 0;
  const auto surface = terrain::makeOriginal(*model, terrain::OnDefect::kRepair);
  if (surface.ok()) CHECK_TRUE(terrain::findAdjacency(surface->faces).twins == surface->twins);
  return 0;
}
