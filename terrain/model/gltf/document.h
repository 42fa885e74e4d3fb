// What a glTF 2.0 file says of its shapes and their colours, as plain data whose indices all name something that exists
// (or are kNoIndex). What the data behind it are is not checked yet. Pure; any thread.
#pragma once

#include <array>
#include <cstdint>
#include <glm/mat4x4.hpp>
#include <glm/vec2.hpp>
#include <glm/vec4.hpp>
#include <map>
#include <string>
#include <vector>

#include "base/result.h"
#include "terrain/model/gltf/container.h"
#include "terrain/model/model.h"

namespace foreland::terrain {

enum class GltfType : uint8_t { kInt8, kUint8, kInt16, kUint16, kUint32, kFloat };
size_t gltfTypeBytes(GltfType type);

// Where the bytes are.
struct GltfBuffer {
  std::string uri;
  uint64_t bytes = 0;
};
// How EXT_meshopt_compression has packed a view.
struct GltfMeshopt {
  uint32_t buffer = kNoIndex;
  uint64_t offset = 0, bytes = 0, count = 0;
  uint32_t stride = 0;
  std::string mode, filter;
};
struct GltfView {
  uint32_t buffer = kNoIndex;
  uint64_t offset = 0, bytes = 0;
  uint32_t stride = 0;  // 0: elements stand side by side
  GltfMeshopt meshopt;  // if it has a buffer
};

// What the bytes mean.
struct GltfElements {
  uint32_t view = kNoIndex;  // kNoIndex: all zero
  uint64_t offset = 0, count = 0;
  GltfType type = GltfType::kFloat;
};
struct GltfAccessor {
  GltfElements elements;
  uint32_t components = 1;
  bool is_normalised = false;   // whole numbers stand for -1 to 1, or 0 to 1
  GltfElements places, values;  // of the elements that differ, if places.count > 0; same type and components
};

struct GltfPrimitive {
  std::map<std::string, uint32_t> attributes;  // accessors
  uint32_t indices = kNoIndex, material = kNoIndex;
  uint32_t mode = 4;
  uint32_t draco_view = kNoIndex;
  std::map<std::string, uint32_t> draco_attributes;  // their ids in the compressed mesh
};

struct GltfMaterial {
  std::string name;
  glm::dvec4 factor{1};  // linear
  uint32_t image = kNoIndex, coordinates = 0;
  bool lacks_image = false;        // it has a texture, but in no format that is read
  glm::dvec2 offset{0}, scale{1};  // of texture coordinates
  double rotation_rad = 0;
};

struct GltfImage {
  std::string uri;
  uint32_t view = kNoIndex;
};

struct GltfNode {
  glm::dmat4 transform{1};
  uint32_t mesh = kNoIndex;
  std::vector<uint32_t> children;
  bool is_skinned = false;
};

// The same as EXT_meshopt_compression in newer words, which are not read.
inline constexpr const char* kKhronosMeshopt = "KHR_meshopt_compression";

struct GltfDocument {
  std::vector<GltfBuffer> buffers;
  std::vector<GltfView> views;
  std::vector<GltfAccessor> accessors;
  std::vector<std::vector<GltfPrimitive>> meshes;
  std::vector<GltfMaterial> materials;
  std::vector<GltfImage> images;
  std::vector<GltfNode> nodes;
  std::vector<std::string> unknown_extensions;  // that the file uses, but does not require
  std::map<std::string, uint64_t> left_out;     // what has no place here, with its count
  std::vector<uint32_t> roots;                  // nodes of the scene; of all if the file names no scene
};

// Error, without the file's name: what is missing, of another type or names nothing, with its path in the JSON; an
// extension that the file requires and this reader lacks.
[[nodiscard]] Result<GltfDocument> parseGltfDocument(const nlohmann::json& json);

}  // namespace foreland::terrain
