#include "terrain/model/gltf/draco.h"

#include <draco/compression/decode.h>
#include <draco/mesh/mesh.h>

#include <exception>
#include <memory>
#include <utility>

#include "terrain/model/model.h"

namespace foreland::terrain {

namespace {

Error refusedDraco(const std::string& what) {
  return {ErrorCode::kMalformed, "has Draco data " + what + "; export the model again"};
}

// Whole numbers that stand for shares are converted to shares.
Result<std::vector<double>> readAttribute(const draco::Mesh& mesh, const draco::PointAttribute& attribute) {
  const auto components = static_cast<uint32_t>(attribute.num_components());
  std::vector<double> values(uint64_t{mesh.num_points()} * components);
  for (uint32_t i = 0; i < mesh.num_points(); ++i) {
    const draco::AttributeValueIndex at = attribute.mapped_index(draco::PointIndex(i));
    if (at.value() >= attribute.size() || !attribute.ConvertValue(at, &values[uint64_t{i} * components]))
      return refusedDraco("in which a point has no value");
  }
  return values;
}

Result<DracoMesh> unpack(ByteSpan bytes, const std::map<std::string, uint32_t>& attributes) {
  draco::DecoderBuffer buffer;
  buffer.Init(reinterpret_cast<const char*>(bytes.data()), bytes.size());
  auto decoded = draco::Decoder().DecodeMeshFromBuffer(&buffer);
  if (!decoded.ok()) return refusedDraco("that is damaged (" + decoded.status().error_msg_string() + ")");
  const draco::Mesh& mesh = *decoded.value();
  if (mesh.num_points() > kMaxModelVertices || mesh.num_faces() > kMaxModelVertices)
    return Error{ErrorCode::kLimit, "has more than 134217728 vertices; simplify the model"};
  DracoMesh made;
  made.faces.reserve(mesh.num_faces());
  for (uint32_t f = 0; f < mesh.num_faces(); ++f) {
    const draco::Mesh::Face& face = mesh.face(draco::FaceIndex(f));
    made.faces.push_back({face[0].value(), face[1].value(), face[2].value()});
  }
  for (const auto& [name, id] : attributes) {
    const draco::PointAttribute* attribute = mesh.GetAttributeByUniqueId(id);
    if (attribute == nullptr || attribute->num_components() < 1) return refusedDraco("without its attribute " + name);
    auto values = readAttribute(mesh, *attribute);
    if (!values.ok()) return values.error();
    made.components[name] = static_cast<uint32_t>(attribute->num_components());
    made.attributes[name] = std::move(values).value();
  }
  return made;
}

}  // namespace

Result<DracoMesh> unpackDraco(ByteSpan bytes, const std::map<std::string, uint32_t>& attributes) {
  try {
    return unpack(bytes, attributes);
  } catch (const std::exception&) {  // of vectors of absurd sizes
    return refusedDraco("that promises more than memory can hold");
  }
}

}  // namespace foreland::terrain
