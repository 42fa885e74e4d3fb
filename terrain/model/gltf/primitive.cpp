#include "terrain/model/gltf/primitive.h"

#include <algorithm>
#include <numeric>
#include <optional>
#include <string>
#include <utility>

#include "terrain/model/gltf/draco.h"

namespace foreland::terrain {

namespace {

constexpr uint32_t kTriangles = 4, kStrip = 5, kFan = 6;

Error malformedPrimitive(std::string what) {
  return {ErrorCode::kMalformed, std::move(what) + "; export the model again"};
}

// The numbers of an attribute, and how many each element has.
struct Attribute {
  std::vector<double> numbers;
  uint32_t components = 0;
};

class PrimitiveReader {
 public:
  PrimitiveReader(const GltfDocument& document, const GltfPrimitive& primitive, GltfBuffers& buffers)
      : document_(document), primitive_(primitive), buffers_(buffers) {}

  Result<GltfTriangles> read(uint32_t coordinates) {
    const std::string uv = "TEXCOORD_" + std::to_string(coordinates);
    if (Status status = unpack({"POSITION", "COLOR_0", uv}); !status.ok()) return status.error();
    for (const auto& [name, wanted, out] :
         {std::tuple("POSITION", 3u, &made_.positions), std::tuple(uv.c_str(), 2u, &made_.texture_coordinates),
          std::tuple("COLOR_0", 4u, &made_.colours)})
      if (Status status = take(name, wanted, *out); !status.ok()) return status.error();
    if (made_.positions.empty()) return malformedPrimitive("has no positions");
    if (Status status = readFaces(); !status.ok()) return status.error();
    return std::move(made_);
  }

 private:
  Status unpack(const std::vector<std::string>& wanted) {
    if (primitive_.draco_view == kNoIndex) return {};
    const auto bytes = buffers_.view(primitive_.draco_view);
    if (!bytes.ok()) return bytes.error();
    std::map<std::string, uint32_t> ids;
    for (const std::string& name : wanted)
      if (const auto found = primitive_.draco_attributes.find(name); found != primitive_.draco_attributes.end())
        ids.insert(*found);
    auto mesh = unpackDraco(*bytes, ids);
    if (!mesh.ok()) return mesh.error();
    draco_ = std::move(mesh).value();
    return {};
  }

  Result<Attribute> attribute(const char* name) {
    if (draco_)
      if (const auto found = draco_->attributes.find(name); found != draco_->attributes.end())
        return Attribute{std::move(found->second), draco_->components.at(name)};
    const auto found = primitive_.attributes.find(name);
    if (found == primitive_.attributes.end()) return Attribute{};
    auto numbers = buffers_.numbers(found->second);
    if (!numbers.ok()) return numbers.error();
    return Attribute{std::move(numbers).value(), document_.accessors[found->second].components};
  }
  // Colours may lack alpha.
  Status take(const char* name, uint32_t wanted, std::vector<double>& out) {
    auto read = attribute(name);
    if (!read.ok()) return read.error();
    if (read->numbers.empty()) return {};
    const bool lacks_alpha = wanted == 4 && read->components == 3;
    if (read->components != wanted && !lacks_alpha)
      return malformedPrimitive(std::string(name) + " has " + std::to_string(read->components) +
                                " components instead of " + std::to_string(wanted));
    const size_t count = read->numbers.size() / read->components;
    if (!made_.positions.empty() && count != made_.count())
      return malformedPrimitive(std::string(name) + " has " + std::to_string(count) + " elements, but there are " +
                                std::to_string(made_.count()) + " positions");
    if (!lacks_alpha) return out = std::move(read->numbers), Status();
    for (size_t i = 0; i < count; ++i)
      out.insert(out.end(), {read->numbers[3 * i], read->numbers[3 * i + 1], read->numbers[3 * i + 2], 1});
    return {};
  }

  Status readFaces() {
    std::vector<uint32_t> order;
    if (draco_) {
      made_.faces = std::move(draco_->faces);
    } else if (primitive_.indices != kNoIndex) {
      auto indices = buffers_.indices(primitive_.indices);
      if (!indices.ok()) return indices.error();
      order = std::move(indices).value();
    } else {
      order.resize(made_.count());
      std::iota(order.begin(), order.end(), 0);
    }
    if (!draco_)
      if (Status status = assemble(order); !status.ok()) return status;
    for (const auto& face : made_.faces)
      for (const uint32_t v : face)
        if (v >= made_.count())
          return malformedPrimitive("names vertex " + std::to_string(v) + ", but there are only " +
                                    std::to_string(made_.count()));
    return {};
  }
  Status assemble(const std::vector<uint32_t>& order) {
    const size_t size = order.size();
    if (primitive_.mode == kTriangles && size % 3 != 0)
      return malformedPrimitive("has " + std::to_string(size) + " corners, which are no triangles");
    const size_t step = primitive_.mode == kTriangles ? 3 : 1;
    for (size_t i = 0; i + 2 < size; i += step) {
      const bool is_odd = primitive_.mode == kStrip && i % 2 == 1;
      const uint32_t first = order[primitive_.mode == kFan ? 0 : i], b = order[i + 1], c = order[i + 2];
      made_.faces.push_back({first, is_odd ? c : b, is_odd ? b : c});
    }
    return {};
  }

  const GltfDocument& document_;
  const GltfPrimitive& primitive_;
  GltfBuffers& buffers_;
  std::optional<DracoMesh> draco_;
  GltfTriangles made_;
};

}  // namespace

Result<GltfTriangles> readPrimitive(const GltfDocument& document, const GltfPrimitive& primitive, uint32_t coordinates,
                                    GltfBuffers& buffers) {
  return PrimitiveReader(document, primitive, buffers).read(coordinates);
}

bool isOfTriangles(const GltfPrimitive& primitive) {
  return primitive.mode == kTriangles || primitive.mode == kStrip || primitive.mode == kFan;
}

}  // namespace foreland::terrain
