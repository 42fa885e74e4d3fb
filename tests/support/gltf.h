// glTF files made by tests: JSON and one buffer, written in any of the ways the format has.
#pragma once

#include <array>
#include <cstdint>
#include <cstring>
#include <nlohmann/json.hpp>
#include <string>
#include <utility>
#include <vector>

#include "base/bytes.h"
#include "terrain/model/model.h"

namespace foreland::test {

using Json = nlohmann::json;

template <class T>
Bytes bytesOf(const std::vector<T>& values) {
  Bytes bytes(values.size() * sizeof(T));
  std::memcpy(bytes.data(), values.data(), bytes.size());
  return bytes;
}

inline std::string toBase64(const Bytes& bytes) {
  static constexpr char kDigits[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string text;
  for (size_t i = 0; i < bytes.size(); i += 3) {
    uint32_t word = 0;
    for (size_t k = 0; k < 3; ++k) word = word << 8 | (i + k < bytes.size() ? bytes[i + k] : 0);
    for (size_t k = 0; k < 4; ++k) text += i + k > bytes.size() ? '=' : kDigits[word >> (18 - 6 * k) & 63];
  }
  return text;
}

enum class GltfPadding : uint8_t { kToFour, kNone };

struct GltfFile {
  Json json = {{"asset", {{"version", "2.0"}}}};
  Bytes buffer{};

  // Appends bytes to the buffer; the number of their view.
  size_t addView(const Bytes& bytes, Json about = Json::object()) {
    buffer.resize((buffer.size() + 3) / 4 * 4);
    about["buffer"] = 0, about["byteOffset"] = buffer.size(), about["byteLength"] = bytes.size();
    buffer.insert(buffer.end(), bytes.begin(), bytes.end());
    return append("bufferViews", about);
  }
  size_t addAccessor(size_t view, int type, const std::string& shape, size_t count) {
    return append("accessors", {{"bufferView", view}, {"componentType", type}, {"type", shape}, {"count", count}});
  }
  size_t append(const char* array, const Json& element) {
    json[array].push_back(element);
    return json[array].size() - 1;
  }

  std::string toGlb(GltfPadding padding = GltfPadding::kToFour) const {
    Json whole = json;
    whole["buffers"][0]["byteLength"] = buffer.size();
    std::string text = whole.dump(), out = "glTF";
    Bytes padded = buffer;
    if (padding == GltfPadding::kToFour)
      text.resize((text.size() + 3) / 4 * 4, ' '), padded.resize((padded.size() + 3) / 4 * 4);
    const auto put = [&](size_t word) {
      for (int shift = 0; shift < 32; shift += 8) out += static_cast<char>(word >> shift & 255);
    };
    put(2), put(12 + 8 + text.size() + 8 + padded.size());
    put(text.size()), out += "JSON" + text;
    put(padded.size()), out += std::string("BIN\0", 4);
    out.append(padded.begin(), padded.end());
    return out;
  }
  // The JSON of a .gltf whose buffer is at `uri`; empty for a data URI.
  std::string toText(std::string uri = {}) const {
    Json whole = json;
    if (uri.empty()) uri = "data:application/octet-stream;base64," + toBase64(buffer);
    whole["buffers"][0] = {{"byteLength", buffer.size()}, {"uri", uri}};
    return whole.dump();
  }
};

inline std::vector<float> floatsOf(const std::vector<glm::dvec3>& positions) {
  std::vector<float> floats;
  for (const glm::dvec3& p : positions)
    for (int axis = 0; axis < 3; ++axis) floats.push_back(static_cast<float>(p[axis]));
  return floats;
}

inline std::vector<uint32_t> indicesOf(const terrain::Model& triangles) {
  std::vector<uint32_t> indices;
  for (const terrain::Corner& corner : triangles.corners) indices.push_back(corner.vertex);
  return indices;
}

// Positions and triangles of a model, as the primitive of mesh 0 at node 0.
inline GltfFile toGltf(const terrain::Model& triangles) {
  GltfFile file;
  const size_t positions =
      file.addAccessor(file.addView(bytesOf(floatsOf(triangles.positions))), 5126, "VEC3", triangles.positions.size());
  const std::vector<uint32_t> indices = indicesOf(triangles);
  const size_t corners = file.addAccessor(file.addView(bytesOf(indices)), 5125, "SCALAR", indices.size());
  file.append("meshes", {{"primitives", {{{"attributes", {{"POSITION", positions}}}, {"indices", corners}}}}});
  file.append("nodes", {{"mesh", 0}});
  file.append("scenes", {{"nodes", {0}}});
  return file;
}

}  // namespace foreland::test
