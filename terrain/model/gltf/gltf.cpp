#include <algorithm>
#include <cmath>
#include <glm/mat3x3.hpp>
#include <glm/matrix.hpp>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "terrain/model/checked_model.h"
#include "terrain/model/gltf/buffers.h"
#include "terrain/model/gltf/container.h"
#include "terrain/model/gltf/document.h"
#include "terrain/model/gltf/primitive.h"
#include "terrain/model/gltf/uri.h"
#include "terrain/model/read_model.h"
#include "terrain/srgb.h"

namespace foreland::terrain {

namespace {

using glm::dmat4;
using glm::dvec4;

uint8_t byteOf(double share) { return static_cast<uint8_t>(std::lround(share * 255)); }

Colour toColour(const dvec4& linear) {
  const double alpha = linear.a > 0 ? std::min(linear.a, 1.0) : 0;
  return {byteOf(srgbOfLinear(linear.r)), byteOf(srgbOfLinear(linear.g)), byteOf(srgbOfLinear(linear.b)),
          byteOf(alpha)};
}

class GltfBuilder {
 public:
  GltfBuilder(const GltfDocument& document, ByteSpan binary, const std::string& name, const FileReader& read_file)
      : document_(document), buffers_(document, binary, read_file), model_(name, 0), meshes_(document.meshes.size()) {
    for (const auto& mesh : document.meshes)
      for (const GltfPrimitive& primitive : mesh) has_colours_ |= primitive.attributes.contains("COLOR_0");
  }

  Result<Model> build() {
    model_.edit().up = UpAxis::kY;
    for (const std::string& name : document_.unknown_extensions)
      model_.edit().notes.push_back("without the extension " + name + ", which is not supported");
    for (const auto& [what, count] : document_.left_out) model_.leaveOut(what, count);
    addMaterials();
    if (Status status = addNodes(); !status.ok()) return status.error();
    note("points or lines", left_out_.size(), "left out");
    note("skinned meshes", skinned_.size(), "taken as they rest");
    return model_.finish();
  }

 private:
  void note(const std::string& what, size_t count, const std::string& how) {
    if (count > 0) model_.edit().notes.push_back(what + " " + how + ": " + std::to_string(count));
  }

  void addMaterials() {
    std::vector<std::shared_ptr<const Bytes>> images(document_.images.size());
    for (const GltfMaterial& from : document_.materials) {
      Material material{.name = from.name, .colour = toColour(from.factor), .tint = from.factor};
      Status status;
      if (from.lacks_image)
        status = Error{ErrorCode::kUnsupported, "it has no PNG, JPEG or WebP image; export it with one"};
      else if (from.image != kNoIndex)
        status = addImage(from.image, images[from.image], material);
      if (!status.ok())
        model_.edit().notes.push_back("without the texture of material '" + from.name + "': " + status.error().message);
      model_.edit().materials.push_back(std::move(material));
    }
  }
  // `shared`: the image's bytes, if it is in the file and another material had it before.
  Status addImage(uint32_t image, std::shared_ptr<const Bytes>& shared, Material& material) {
    const GltfImage& about = document_.images[image];
    if (about.view == kNoIndex && !isDataUri(about.uri)) {
      const auto file = fileOfUri(about.uri);
      if (!file.ok()) return file.error();
      material.texture = *file;
      return {};
    }
    if (!shared) {
      auto bytes = about.view == kNoIndex ? decodeDataUri(about.uri) : copyOf(about.view);
      if (!bytes.ok()) return bytes.error();
      shared = std::make_shared<const Bytes>(std::move(bytes).value());
    }
    material.texture = "images[" + std::to_string(image) + "]", material.embedded = shared;
    return {};
  }
  Result<Bytes> copyOf(uint32_t view) {
    const auto bytes = buffers_.view(view);
    if (!bytes.ok()) return bytes.error();
    return Bytes(bytes->begin(), bytes->end());
  }

  // Each node has one parent at most and roots have none, so every node is met once.
  Status addNodes() {
    std::vector<std::pair<uint32_t, dmat4>> waiting;
    const auto add = [&](const std::vector<uint32_t>& nodes, const dmat4& parent) {
      for (auto node = nodes.rbegin(); node != nodes.rend(); ++node)
        waiting.emplace_back(*node, parent * document_.nodes[*node].transform);
    };
    add(document_.roots, dmat4(1));
    while (!waiting.empty()) {
      const auto [index, transform] = waiting.back();
      waiting.pop_back();
      const GltfNode& node = document_.nodes[index];
      if (node.mesh != kNoIndex && node.is_skinned) skinned_.insert(index);
      if (node.mesh != kNoIndex)
        if (Status status = addMesh(node.mesh, node.is_skinned ? dmat4(1) : transform); !status.ok()) return status;
      add(node.children, transform);
    }
    if (document_.nodes.empty())
      for (uint32_t mesh = 0; mesh < document_.meshes.size(); ++mesh)
        if (Status status = addMesh(mesh, dmat4(1)); !status.ok()) return status;
    return {};
  }

  Status addMesh(uint32_t mesh, const dmat4& transform) {
    const auto& primitives = document_.meshes[mesh];
    meshes_[mesh].resize(primitives.size());
    std::map<uint32_t, uint32_t> first_vertices;  // of accessors of positions
    for (size_t p = 0; p < primitives.size(); ++p) {
      const auto fail = [&](const Error& error) {
        return Error{error.code,
                     "meshes[" + std::to_string(mesh) + "].primitives[" + std::to_string(p) + "] " + error.message};
      };
      if (!isOfTriangles(primitives[p])) {
        left_out_.emplace(mesh, p);
        continue;
      }
      if (Status status = read(primitives[p], meshes_[mesh][p]); !status.ok()) return fail(status.error());
      Status status = addPrimitive(primitives[p], *meshes_[mesh][p], transform, first_vertices);
      if (!status.ok()) return fail(status.error());
    }
    return {};
  }
  Status read(const GltfPrimitive& primitive, std::optional<GltfTriangles>& triangles) {
    if (triangles) return {};
    const bool is_textured =
        primitive.material != kNoIndex && document_.materials[primitive.material].image != kNoIndex;
    const uint32_t coordinates = is_textured ? document_.materials[primitive.material].coordinates : kNoIndex;
    auto made = readPrimitive(document_, primitive, coordinates, buffers_);
    if (!made.ok()) return made.error();
    triangles = std::move(made).value();
    return {};
  }

  Status addPrimitive(const GltfPrimitive& primitive, const GltfTriangles& triangles, const dmat4& transform,
                      std::map<uint32_t, uint32_t>& first_vertices) {
    auto first_vertex = static_cast<uint32_t>(model_.get().positions.size());
    const auto accessor = primitive.attributes.find("POSITION");
    const bool may_share = accessor != primitive.attributes.end() && primitive.draco_view == kNoIndex && !has_colours_;
    const auto [shared, is_new] =
        may_share ? first_vertices.try_emplace(accessor->second, first_vertex) : std::pair(first_vertices.end(), true);
    if (!is_new)
      first_vertex = shared->second;
    else if (Status status = addVertices(primitive, triangles, transform); !status.ok())
      return status;
    const auto first_coordinate = static_cast<uint32_t>(model_.get().texture_coordinates.size());
    if (Status status = addCoordinates(primitive, triangles); !status.ok()) return status;
    const bool is_mirrored = glm::determinant(glm::dmat3(transform)) < 0;
    for (std::array<uint32_t, 3> face : triangles.faces) {
      if (is_mirrored) std::swap(face[1], face[2]);
      for (const uint32_t v : face)
        model_.addCorner({first_vertex + v, triangles.texture_coordinates.empty() ? kNoIndex : first_coordinate + v});
      if (Status status = model_.endFace(primitive.material); !status.ok()) return status;
    }
    return {};
  }
  Status addVertices(const GltfPrimitive& primitive, const GltfTriangles& triangles, const dmat4& transform) {
    const dvec4 factor = primitive.material == kNoIndex ? dvec4(1) : document_.materials[primitive.material].factor;
    for (size_t v = 0; v < triangles.count(); ++v) {
      const double* p = &triangles.positions[3 * v];
      if (Status status = model_.addPosition(glm::dvec3(transform * dvec4(p[0], p[1], p[2], 1))); !status.ok())
        return status;
      if (!has_colours_) continue;
      dvec4 colour(1);
      if (!triangles.colours.empty())
        for (int k = 0; k < 4; ++k) colour[k] = triangles.colours[4 * v + static_cast<size_t>(k)];
      model_.edit().colours.push_back(toColour(factor * colour));
    }
    return {};
  }
  // KHR_texture_transform; images begin at the top there.
  Status addCoordinates(const GltfPrimitive& primitive, const GltfTriangles& triangles) {
    if (triangles.texture_coordinates.empty()) return {};
    const GltfMaterial& material = document_.materials[primitive.material];
    const double c = std::cos(material.rotation_rad), s = std::sin(material.rotation_rad);
    for (size_t v = 0; v < triangles.count(); ++v) {
      const double x = material.scale.x * triangles.texture_coordinates[2 * v];
      const double y = material.scale.y * triangles.texture_coordinates[2 * v + 1];
      const glm::dvec2 at(c * x + s * y + material.offset.x, c * y - s * x + material.offset.y);
      if (Status status = model_.addTextureCoordinate({at.x, 1 - at.y}); !status.ok()) return status;
    }
    return {};
  }

  const GltfDocument& document_;
  GltfBuffers buffers_;
  CheckedModel model_;
  std::vector<std::vector<std::optional<GltfTriangles>>> meshes_;  // what is read
  bool has_colours_ = false;                                       // whether any vertex has
  std::set<std::pair<uint32_t, size_t>> left_out_;                 // primitives
  std::set<uint32_t> skinned_;                                     // nodes
};

}  // namespace

Result<Model> parseGltf(ByteSpan bytes, const std::string& name, const FileReader& read_file) {
  const auto fail = [&](const Error& error) {
    const bool is_named = error.message.starts_with(name);
    return Error{error.code, is_named ? error.message : name + ": " + error.message};
  };
  const auto container = parseGltfContainer(bytes);
  if (!container.ok()) return fail(container.error());
  const auto document = parseGltfDocument(container->json);
  if (!document.ok()) return fail(document.error());
  auto model = GltfBuilder(*document, container->buffer, name, read_file).build();
  if (!model.ok()) return fail(model.error());
  model->notes.insert(model->notes.begin(), container->notes.begin(), container->notes.end());
  return model;
}

}  // namespace foreland::terrain
