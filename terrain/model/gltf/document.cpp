#include "terrain/model/gltf/document.h"

#include <algorithm>
#include <glm/gtc/quaternion.hpp>
#include <utility>

#include "terrain/model/gltf/json_fields.h"

namespace foreland::terrain {

namespace {

using nlohmann::json;

constexpr uint32_t kMaxStride = 256;

// Those that change how things look alone may be left out.
bool isKnownExtension(const std::string& name) {
  static constexpr const char* kRead[] = {"KHR_draco_mesh_compression", "EXT_meshopt_compression",
                                          "KHR_mesh_quantization", "KHR_lights_punctual"};
  static constexpr const char* kOfLooks[] = {"KHR_materials_", "KHR_texture_", "EXT_texture_", "MSFT_texture_",
                                             "KHR_animation_"};
  return std::any_of(std::begin(kRead), std::end(kRead), [&](const char* known) { return name == known; }) ||
         std::any_of(std::begin(kOfLooks), std::end(kOfLooks),
                     [&](const char* begin) { return name.starts_with(begin); });
}

// How to make a file without an extension that is required.
std::string wayOut(const std::string& name) {
  return name == kKhronosMeshopt ? "pack it with EXT_meshopt_compression (gltfpack -c), or not at all"
                                 : "export the model without it";
}

size_t countOf(const json& root, const char* key) {
  const auto found = root.find(key);
  return found != root.end() && found->is_array() ? found->size() : 0;
}

class DocumentParser {
 public:
  explicit DocumentParser(const json& root) : root_(root), top_{&root, ""} {}

  Result<GltfDocument> parse() {
    if (Status status = checkVersion(); !status.ok()) return status.error();
    parseBuffers();
    parseAccessors();
    parseImages();
    parseMaterials();
    parseMeshes();
    parseNodes();
    made_.left_out["animations"] += countOf(root_, "animations");
    if (!fields_.status().ok()) return fields_.status().error();
    return std::move(made_);
  }

 private:
  Status checkVersion() {
    const std::string version = fields_.text(fields_.object(top_, "asset"), "version");
    if (!version.starts_with("2."))
      return Error{ErrorCode::kUnsupported,
                   "is glTF of version '" + version.substr(0, 20) + "'; export it as glTF 2.0"};
    for (const json& name : elementsOf("extensionsUsed"))
      if (name.is_string() && !isKnownExtension(name.get<std::string>()))
        made_.unknown_extensions.push_back(name.get<std::string>().substr(0, 60));
    for (const json& name : elementsOf("extensionsRequired"))
      if (!name.is_string() || !isKnownExtension(name.get<std::string>()))
        return Error{ErrorCode::kUnsupported,
                     "requires the extension " +
                         name.dump(-1, ' ', true, json::error_handler_t::replace).substr(0, 60) +
                         ", which is not supported; " + wayOut(name.is_string() ? name.get<std::string>() : "")};
    return {};
  }

  const json& elementsOf(const char* key) const {
    static const json kNone = json::array();
    const auto found = root_.find(key);
    return found != root_.end() && found->is_array() ? *found : kNone;
  }

  void parseBuffers() {
    fields_.forObjects(top_, "buffers", [&](const JsonObject& o, uint32_t) {
      made_.buffers.push_back({fields_.text(o, "uri"), fields_.wholeThatMustBe(o, "byteLength", kMaxModelBytes)});
    });
    fields_.forObjects(top_, "bufferViews", [&](const JsonObject& o, uint32_t) {
      GltfView view;
      view.buffer = indexThatMustBe(o, "buffer", made_.buffers.size());
      view.offset = fields_.whole(o, "byteOffset", kMaxModelBytes, 0);
      view.bytes = fields_.wholeThatMustBe(o, "byteLength", kMaxModelBytes);
      view.stride = static_cast<uint32_t>(fields_.whole(o, "byteStride", kMaxStride, 0));
      if (JsonFields::has(fields_.object(o, "extensions"), "EXT_meshopt_compression"))
        view.meshopt = parseMeshopt(fields_.object(fields_.object(o, "extensions"), "EXT_meshopt_compression"));
      made_.views.push_back(std::move(view));
    });
  }
  GltfMeshopt parseMeshopt(const JsonObject& o) {
    GltfMeshopt packed;
    packed.buffer = indexThatMustBe(o, "buffer", made_.buffers.size());
    packed.offset = fields_.whole(o, "byteOffset", kMaxModelBytes, 0);
    packed.bytes = fields_.wholeThatMustBe(o, "byteLength", kMaxModelBytes);
    packed.count = fields_.wholeThatMustBe(o, "count", kMaxModelBytes);
    packed.stride = static_cast<uint32_t>(fields_.wholeThatMustBe(o, "byteStride", kMaxStride));
    packed.mode = fields_.text(o, "mode"), packed.filter = fields_.text(o, "filter");
    return packed;
  }

  void parseAccessors() {
    fields_.forObjects(top_, "accessors", [&](const JsonObject& o, uint32_t) {
      GltfAccessor accessor;
      accessor.elements = parseElements(o, "bufferView");
      accessor.elements.count = fields_.wholeThatMustBe(o, "count", kMaxModelVertices);
      accessor.components = parseComponents(o);
      accessor.is_normalised = fields_.flag(o, "normalized");
      if (const JsonObject sparse = fields_.object(o, "sparse"); JsonFields::has(sparse, "count")) {
        accessor.places = parseElements(fields_.object(sparse, "indices"), "bufferView");
        accessor.values = parseElements(fields_.object(sparse, "values"), "bufferView");
        accessor.values.type = accessor.elements.type;
        accessor.places.count = accessor.values.count = fields_.whole(sparse, "count", accessor.elements.count, 0);
      }
      made_.accessors.push_back(accessor);
    });
  }
  GltfElements parseElements(const JsonObject& o, const char* view) {
    GltfElements elements;
    elements.view = fields_.index(o, view, made_.views.size());
    elements.offset = fields_.whole(o, "byteOffset", kMaxModelBytes, 0);
    static constexpr std::array<std::pair<uint64_t, GltfType>, 6> kTypes{{{5120, GltfType::kInt8},
                                                                          {5121, GltfType::kUint8},
                                                                          {5122, GltfType::kInt16},
                                                                          {5123, GltfType::kUint16},
                                                                          {5125, GltfType::kUint32},
                                                                          {5126, GltfType::kFloat}}};
    const uint64_t code = fields_.whole(o, "componentType", 0xffff, 5126);
    const auto found = std::find_if(kTypes.begin(), kTypes.end(), [&](const auto& type) { return type.first == code; });
    if (found == kTypes.end())
      fields_.fail(o.path + "componentType", "is " + std::to_string(code) + ", which is no type of numbers");
    else
      elements.type = found->second;
    return elements;
  }
  uint32_t parseComponents(const JsonObject& o) {
    static const std::map<std::string, uint32_t> kCounts{{"SCALAR", 1}, {"VEC2", 2}, {"VEC3", 3}, {"VEC4", 4},
                                                         {"MAT2", 4},   {"MAT3", 9}, {"MAT4", 16}};
    const auto found = kCounts.find(fields_.text(o, "type"));
    if (found != kCounts.end()) return found->second;
    fields_.fail(o.path + "type", "is no type of elements");
    return 1;
  }

  void parseImages() {
    fields_.forObjects(top_, "images", [&](const JsonObject& o, uint32_t) {
      made_.images.push_back({fields_.text(o, "uri"), fields_.index(o, "bufferView", made_.views.size())});
    });
    fields_.forObjects(top_, "textures", [&](const JsonObject& o, uint32_t) {
      uint32_t image = fields_.index(o, "source", made_.images.size());
      const JsonObject webp = fields_.object(fields_.object(o, "extensions"), "EXT_texture_webp");
      if (JsonFields::has(webp, "source")) image = fields_.index(webp, "source", made_.images.size());
      textures_.push_back(image);
    });
  }

  void parseMaterials() {
    if (countOf(root_, "materials") > kMaxModelMaterials) fields_.fail("materials", "are more than 65536");
    fields_.forObjects(top_, "materials", [&](const JsonObject& o, uint32_t) {
      GltfMaterial material;
      material.name = fields_.text(o, "name").substr(0, kMaxModelMaterials);
      const JsonObject colours = fields_.object(o, "pbrMetallicRoughness");
      fields_.numbers(colours, "baseColorFactor", 4, &material.factor[0]);
      if (JsonFields::has(colours, "baseColorTexture"))
        parseTexture(fields_.object(colours, "baseColorTexture"), material);
      uint64_t& left_out = made_.left_out["maps of materials (normal, gloss, glow, occlusion)"];
      left_out += JsonFields::has(colours, "metallicRoughnessTexture");
      for (const char* map : {"normalTexture", "occlusionTexture", "emissiveTexture"})
        left_out += JsonFields::has(o, map);
      const JsonObject extensions = fields_.object(o, "extensions");
      if (JsonFields::has(extensions, "KHR_materials_pbrSpecularGlossiness"))
        parseDiffuse(fields_.object(extensions, "KHR_materials_pbrSpecularGlossiness"), material);
      made_.materials.push_back(std::move(material));
    });
  }
  // What older files have instead of base colours, or besides them.
  void parseDiffuse(const JsonObject& o, GltfMaterial& material) {
    material.factor = glm::dvec4(1), material.image = kNoIndex;
    fields_.numbers(o, "diffuseFactor", 4, &material.factor[0]);
    if (JsonFields::has(o, "diffuseTexture")) parseTexture(fields_.object(o, "diffuseTexture"), material);
  }
  void parseTexture(const JsonObject& o, GltfMaterial& material) {
    const uint32_t texture = indexThatMustBe(o, "index", textures_.size());
    material.image = texture == kNoIndex ? kNoIndex : textures_[texture];
    material.lacks_image = material.image == kNoIndex;
    material.coordinates = static_cast<uint32_t>(fields_.whole(o, "texCoord", 0xffff, 0));
    const JsonObject transform = fields_.object(fields_.object(o, "extensions"), "KHR_texture_transform");
    material.coordinates = static_cast<uint32_t>(fields_.whole(transform, "texCoord", 0xffff, material.coordinates));
    material.rotation_rad = fields_.number(transform, "rotation", 0);
    fields_.numbers(transform, "offset", 2, &material.offset[0]);
    fields_.numbers(transform, "scale", 2, &material.scale[0]);
  }

  void parseMeshes() {
    fields_.forObjects(top_, "meshes", [&](const JsonObject& mesh, uint32_t) {
      made_.meshes.emplace_back();
      fields_.forObjects(mesh, "primitives",
                         [&](const JsonObject& o, uint32_t) { made_.meshes.back().push_back(parsePrimitive(o)); });
    });
  }
  GltfPrimitive parsePrimitive(const JsonObject& o) {
    GltfPrimitive primitive;
    if (JsonFields::has(o, "targets")) ++made_.left_out["shapes that parts morph to"];
    primitive.attributes = parseNamed(fields_.object(o, "attributes"), made_.accessors.size());
    primitive.indices = fields_.index(o, "indices", made_.accessors.size());
    primitive.material = fields_.index(o, "material", made_.materials.size());
    primitive.mode = static_cast<uint32_t>(fields_.whole(o, "mode", 6, 4));
    const JsonObject extensions = fields_.object(o, "extensions");
    if (!JsonFields::has(extensions, "KHR_draco_mesh_compression")) return primitive;
    const JsonObject draco = fields_.object(extensions, "KHR_draco_mesh_compression");
    primitive.draco_view = indexThatMustBe(draco, "bufferView", made_.views.size());
    primitive.draco_attributes = parseNamed(fields_.object(draco, "attributes"), kNoIndex);
    return primitive;
  }
  std::map<std::string, uint32_t> parseNamed(const JsonObject& o, uint64_t count) {
    std::map<std::string, uint32_t> named;
    for (const auto& [name, value] : o.json->items()) named[name] = fields_.index(o, name.c_str(), count);
    return named;
  }

  void parseNodes() {
    const size_t count = countOf(root_, "nodes");
    std::vector<bool> is_child(count);
    fields_.forObjects(top_, "nodes", [&](const JsonObject& o, uint32_t) {
      GltfNode node;
      node.mesh = fields_.index(o, "mesh", made_.meshes.size());
      node.is_skinned = JsonFields::has(o, "skin");
      node.children = fields_.indices(o, "children", count);
      for (const uint32_t child : node.children) {
        if (is_child[child])
          fields_.fail("nodes[" + std::to_string(child) + "]", "is a child of several nodes, or twice");
        is_child[child] = true;
      }
      node.transform = parseTransform(o);
      made_.nodes.push_back(std::move(node));
    });
    parseRoots(is_child);
  }
  glm::dmat4 parseTransform(const JsonObject& o) {
    glm::dmat4 matrix(1);
    if (fields_.numbers(o, "matrix", 16, &matrix[0][0])) return matrix;
    double translation[3] = {0, 0, 0}, turn[4] = {0, 0, 0, 1}, scale[3] = {1, 1, 1};
    fields_.numbers(o, "translation", 3, translation);
    fields_.numbers(o, "scale", 3, scale);
    if (fields_.numbers(o, "rotation", 4, turn))
      matrix = glm::mat4_cast(glm::dquat(turn[3], turn[0], turn[1], turn[2]));
    for (int axis = 0; axis < 3; ++axis) matrix[axis] *= scale[axis], matrix[3][axis] = translation[axis];
    return matrix;
  }
  void parseRoots(const std::vector<bool>& is_child) {
    const uint32_t scene = fields_.index(top_, "scene", countOf(root_, "scenes"));
    fields_.forObjects(top_, "scenes", [&](const JsonObject& o, uint32_t i) {
      if (i == (scene == kNoIndex ? 0 : scene)) made_.roots = fields_.indices(o, "nodes", is_child.size());
    });
    for (const uint32_t root : made_.roots)
      if (is_child[root]) fields_.fail("nodes[" + std::to_string(root) + "]", "is a child, but also a scene's root");
    if (countOf(root_, "scenes") == 0)
      for (uint32_t i = 0; i < is_child.size(); ++i)
        if (!is_child[i]) made_.roots.push_back(i);
  }

  uint32_t indexThatMustBe(const JsonObject& o, const char* key, uint64_t count) {
    if (!JsonFields::has(o, key)) fields_.fail(o.path + key, "is missing");
    return fields_.index(o, key, count);
  }

  const json& root_;
  JsonObject top_;
  JsonFields fields_;
  GltfDocument made_;
  std::vector<uint32_t> textures_;  // the image of each
};

}  // namespace

size_t gltfTypeBytes(GltfType type) {
  switch (type) {
    case GltfType::kInt8:
    case GltfType::kUint8:
      return 1;
    case GltfType::kInt16:
    case GltfType::kUint16:
      return 2;
    case GltfType::kUint32:
    case GltfType::kFloat:
      return 4;
  }
  return 4;
}

Result<GltfDocument> parseGltfDocument(const json& root) { return DocumentParser(root).parse(); }

}  // namespace foreland::terrain
