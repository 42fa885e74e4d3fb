// A polygon model as in its file: faces of any number of corners, with colours and texture coordinates. Readers
// guarantee that every index is in range, every coordinate finite and within kMaxCoordinate, and every face has at
// least three corners. Whether the model is a surface (manifold, no face without area) is checked by
// terrain/remesh/original. Plain data; any thread may read it.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <glm/vec4.hpp>
#include <memory>
#include <string>
#include <vector>

#include "base/bytes.h"

namespace foreland::terrain {

inline constexpr uint32_t kNoIndex = 0xffffffff;
inline constexpr double kMaxCoordinate = 1e9;             // units of the file; far beyond any real model
inline constexpr uint64_t kMaxModelVertices = 1u << 27;   // also of texture coordinates, and of faces
inline constexpr uint32_t kMaxFaceCorners = 1u << 10;     // of one face
inline constexpr uint64_t kMaxModelBytes = 1ull << 33;    // of a model's file
inline constexpr uint32_t kMaxModelMaterials = 1u << 16;  // materials, and bytes of the name of each

using Colour = std::array<uint8_t, 4>;  // red, green, blue, alpha; sRGB

struct Material {
  std::string name;
  std::filesystem::path texture{};  // empty: the colour alone; as the file names it, until readModel finds the file
  std::string library{};            // the file that names the texture, as the model names it; empty: the model itself
  Colour colour{255, 255, 255, 255};
  glm::dvec4 tint{1};                       // of the texture: shares of light, and of opacity
  std::shared_ptr<const Bytes> embedded{};  // the texture's file, if it is part of the model's; `texture` is its name
};

struct Corner {
  uint32_t vertex = 0;
  uint32_t texture = kNoIndex;  // in `texture_coordinates`
};

enum class UpAxis : uint8_t { kY, kZ };

struct Model {
  std::string name;  // of the file
  uint32_t first_number =
      0;  // the file's own name for its first vertex and face: OBJ and STL count from 1, others from 0
  std::vector<glm::dvec3> positions;
  std::vector<Colour> colours;                  // empty, or one for each position
  std::vector<Colour> face_colours;             // empty, or one for each face; drawn where a face has no texture
  std::vector<glm::dvec2> texture_coordinates;  // (0, 0) is the lower left corner of the image
  std::vector<Corner> corners;                  // face after face
  std::vector<uint64_t> face_ends;              // one past each face's last corner
  std::vector<uint32_t> face_materials;         // for each face; kNoIndex for none
  std::vector<Material> materials;
  UpAxis up = UpAxis::kZ;          // by the rule of the file's format; z where it has none
  std::vector<std::string> notes;  // what the reader left out, with counts

  size_t faceCount() const { return face_ends.size(); }
  uint64_t faceBegin(size_t face) const { return face == 0 ? 0 : face_ends[face - 1]; }
  std::string faceName(size_t face) const { return "face " + std::to_string(face + first_number); }
  std::string vertexName(size_t vertex) const { return "vertex " + std::to_string(vertex + first_number); }
};

// Turns a model whose y axis points up so that its z axis does; exact.
inline void standUp(Model& model) {
  for (glm::dvec3& p : model.positions) p = {p.x, -p.z, p.y};
  model.up = UpAxis::kZ;
}

}  // namespace foreland::terrain
