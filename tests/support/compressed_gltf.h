// glTF files made by tests whose meshes are compressed, by Draco or meshoptimizer.
#pragma once

#include <draco/compression/encode.h>
#include <draco/mesh/triangle_soup_mesh_builder.h>
#include <meshoptimizer.h>

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "base/check.h"
#include "tests/support/gltf.h"

namespace foreland::test {

// The file, with the mesh's positions quantised to that many bits. Draco changes the order of vertices and triangles.
inline GltfFile toDracoGltf(const terrain::Model& triangles, int bits) {
  draco::TriangleSoupMeshBuilder builder;
  builder.Start(static_cast<int>(triangles.faceCount()));
  const int positions = builder.AddAttribute(draco::GeometryAttribute::POSITION, 3, draco::DT_FLOAT32);
  const std::vector<float> floats = floatsOf(triangles.positions);
  for (size_t f = 0; f < triangles.faceCount(); ++f) {
    const float* at[3];
    for (size_t k = 0; k < 3; ++k) at[k] = &floats[size_t{3} * triangles.corners[3 * f + k].vertex];
    builder.SetAttributeValuesForFace(positions, draco::FaceIndex(static_cast<uint32_t>(f)), at[0], at[1], at[2]);
  }
  const std::unique_ptr<draco::Mesh> mesh = builder.Finalize();
  draco::Encoder encoder;
  encoder.SetAttributeQuantization(draco::GeometryAttribute::POSITION, bits);
  draco::EncoderBuffer buffer;
  CHECK_TRUE(encoder.EncodeMeshToBuffer(*mesh, &buffer).ok());

  GltfFile file;
  const Bytes packed(buffer.data(), buffer.data() + buffer.size());
  const size_t view = file.addView(packed);
  file.append("accessors", {{"componentType", 5126}, {"type", "VEC3"}, {"count", mesh->num_points()}});
  file.append("accessors", {{"componentType", 5125}, {"type", "SCALAR"}, {"count", 3 * mesh->num_faces()}});
  const Json draco{{"bufferView", view}, {"attributes", {{"POSITION", mesh->attribute(positions)->unique_id()}}}};
  file.append("meshes", {{"primitives",
                          {{{"attributes", {{"POSITION", 0}}},
                            {"indices", 1},
                            {"extensions", {{"KHR_draco_mesh_compression", draco}}}}}}});
  file.append("nodes", {{"mesh", 0}});
  file.json["extensionsRequired"] = {"KHR_draco_mesh_compression"};
  return file;
}

// As gltfpack writes it: 16-bit positions that the node scales back, from -1 to 1, and a second buffer that only says
// how large the unpacked data are.
inline GltfFile toMeshoptGltf(const terrain::Model& triangles) {
  std::vector<int16_t> positions;
  for (const glm::dvec3& p : triangles.positions) {
    for (int axis = 0; axis < 3; ++axis)
      positions.push_back(static_cast<int16_t>(meshopt_quantizeSnorm(static_cast<float>(p[axis] / 2), 16)));
    positions.push_back(0);
  }
  const std::vector<uint32_t> indices = indicesOf(triangles);
  const size_t count = triangles.positions.size();
  Bytes vertices(meshopt_encodeVertexBufferBound(count, 8)),
      corners(meshopt_encodeIndexBufferBound(indices.size(), count));
  vertices.resize(meshopt_encodeVertexBuffer(vertices.data(), vertices.size(), positions.data(), count, 8));
  corners.resize(meshopt_encodeIndexBuffer(corners.data(), corners.size(), indices.data(), indices.size()));

  GltfFile file;
  const auto addPacked = [&](const Bytes& packed, const char* mode, size_t elements, size_t stride) {
    const size_t at = (file.buffer.size() + 3) / 4 * 4;
    file.buffer.resize(at);
    file.buffer.insert(file.buffer.end(), packed.begin(), packed.end());
    const Json meshopt{{"buffer", 0},  {"byteOffset", at},  {"byteLength", packed.size()},
                       {"mode", mode}, {"count", elements}, {"byteStride", stride}};
    return file.append(
        "bufferViews",
        {{"buffer", 1}, {"byteLength", elements * stride}, {"extensions", {{"EXT_meshopt_compression", meshopt}}}});
  };
  file.addAccessor(addPacked(vertices, "ATTRIBUTES", count, 8), 5122, "VEC3", count);
  file.json["accessors"][0]["normalized"] = true;
  file.addAccessor(addPacked(corners, "TRIANGLES", indices.size(), 4), 5125, "SCALAR", indices.size());
  file.append("meshes", {{"primitives", {{{"attributes", {{"POSITION", 0}}}, {"indices", 1}}}}});
  file.append("nodes", {{"mesh", 0}, {"scale", {2, 2, 2}}});
  file.json["buffers"] = {Json::object(),
                          {{"byteLength", count * 8 + indices.size() * 4},
                           {"extensions", {{"EXT_meshopt_compression", {{"fallback", true}}}}}}};
  file.json["extensionsRequired"] = {"EXT_meshopt_compression", "KHR_mesh_quantization"};
  return file;
}

}  // namespace foreland::test
