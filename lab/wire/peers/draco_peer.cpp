#include "lab/wire/peers/draco_peer.h"

#include <draco/compression/decode.h>
#include <draco/compression/expert_encode.h>
#include <draco/core/draco_version.h>
#include <draco/mesh/mesh.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <string>

#include "base/check.h"

namespace foreland::lab {

namespace {

Error refused(const draco::Status& status) { return {ErrorCode::kMalformed, "Draco: " + status.error_msg_string()}; }

void setTriangles(const PeerMesh& mesh, draco::Mesh& out) {
  out.set_num_points(static_cast<uint32_t>(mesh.positions.size()));
  out.SetNumFaces(mesh.indices.size() / 3);
  for (uint32_t i = 0; i < out.num_faces(); ++i) {
    draco::Mesh::Face face;
    for (uint32_t k = 0; k < 3; ++k) face[k] = draco::PointIndex(mesh.indices[3 * i + k]);
    out.SetFace(draco::FaceIndex(i), face);
  }
}

// Components first..first+count-1 of the positions, as an attribute. Returns its id.
template <class T>
int addAttribute(const PeerMesh& mesh, draco::GeometryAttribute::Type type, draco::DataType data, int first, int count,
                 draco::Mesh& out) {
  draco::GeometryAttribute attribute;
  attribute.Init(type, nullptr, static_cast<int8_t>(count), data, false, static_cast<int64_t>(sizeof(T)) * count, 0);
  const int id = out.AddAttribute(attribute, true, static_cast<uint32_t>(mesh.positions.size()));
  for (uint32_t i = 0; i < mesh.positions.size(); ++i) {
    T value[3];
    for (int k = 0; k < count; ++k) value[k] = static_cast<T>(mesh.positions[i][first + k]);
    out.attribute(id)->SetAttributeValue(draco::AttributeValueIndex(i), value);
  }
  return id;
}

Result<Bytes> run(draco::ExpertEncoder& encoder) {
  encoder.SetSpeedOptions(0, 0);
  encoder.SetEncodingMethod(draco::MESH_EDGEBREAKER_ENCODING);
  draco::EncoderBuffer buffer;
  if (const draco::Status status = encoder.EncodeToBuffer(&buffer); !status.ok()) return refused(status);
  return Bytes(buffer.data(), buffer.data() + buffer.size());
}

// The attribute's components go to first, first + 1, ... of the positions.
void takeAttribute(const draco::Mesh& in, int id, int first, PeerMesh& out) {
  const draco::PointAttribute& attribute = *in.attribute(id);
  for (uint32_t i = 0; i < in.num_points(); ++i) {
    double value[3];
    CHECK_TRUE(attribute.ConvertValue(attribute.mapped_index(draco::PointIndex(i)), attribute.num_components(), value));
    for (int k = 0; k < attribute.num_components(); ++k) out.positions[i][first + k] = value[k];
  }
}

// `attributes` in all, which together have x, y and z.
Result<PeerMesh> decode(const Bytes& bytes, int attributes) {
  draco::DecoderBuffer buffer;
  buffer.Init(reinterpret_cast<const char*>(bytes.data()), bytes.size());
  draco::Decoder decoder;
  auto decoded = decoder.DecodeMeshFromBuffer(&buffer);
  if (!decoded.ok()) return refused(decoded.status());
  const draco::Mesh& mesh = *decoded.value();
  if (mesh.num_attributes() != attributes) return Error{ErrorCode::kMalformed, "Draco: attributes are missing"};
  PeerMesh out;
  out.positions.resize(mesh.num_points());
  int first = 0;
  for (int id = 0; id < attributes; first += mesh.attribute(id)->num_components(), ++id)
    if (first + mesh.attribute(id)->num_components() <= 3) takeAttribute(mesh, id, first, out);
  for (uint32_t i = 0; i < mesh.num_faces(); ++i)
    for (uint32_t k = 0; k < 3; ++k) out.indices.push_back(mesh.face(draco::FaceIndex(i))[k].value());
  return out;
}

Result<PeerCode> finish(Bytes bytes, int attributes, const glm::dvec3& tolerance) {
  auto decoded = decode(bytes, attributes);
  if (!decoded) return decoded.error();
  return PeerCode{.bytes = std::move(bytes), .decoded = std::move(decoded).value(), .tolerance = tolerance};
}

}  // namespace

Result<PeerCode> codeDraco(const PeerMesh& mesh) {
  draco::Mesh input;
  setTriangles(mesh, input);
  const int position = addAttribute<float>(mesh, draco::GeometryAttribute::POSITION, draco::DT_FLOAT32, 0, 3, input);
  draco::ExpertEncoder encoder(input);
  encoder.SetAttributeQuantization(position, kDracoPositionBits);
  auto bytes = run(encoder);
  if (!bytes) return bytes.error();
  const Box box = boxAround(mesh);
  const glm::dvec3 extent = box.high - box.low;
  const double longest = std::max({extent.x, extent.y, extent.z});
  // Half a step, and the rounding of its floats.
  const double tolerance = longest * (0.5 / ((1 << kDracoPositionBits) - 1) + 4e-7);
  return finish(std::move(bytes).value(), 1, glm::dvec3(tolerance));
}

Result<PeerCode> codeDracoExactly(const PeerMesh& mesh) {
  for (const glm::dvec3& p : mesh.positions)
    for (int k = 0; k < 3; ++k) CHECK_EQ(p[k], static_cast<double>(static_cast<int32_t>(p[k])));
  draco::Mesh input;
  setTriangles(mesh, input);
  addAttribute<int32_t>(mesh, draco::GeometryAttribute::POSITION, draco::DT_INT32, 0, 2, input);
  const int height = addAttribute<int32_t>(mesh, draco::GeometryAttribute::GENERIC, draco::DT_INT32, 2, 1, input);
  std::optional<Bytes> best;
  for (int predictor : {draco::MESH_PREDICTION_CONSTRAINED_MULTI_PARALLELOGRAM, draco::MESH_PREDICTION_PARALLELOGRAM,
                        draco::PREDICTION_DIFFERENCE}) {
    draco::ExpertEncoder encoder(input);
    if (const draco::Status status = encoder.SetAttributePredictionScheme(height, predictor); !status.ok())
      return refused(status);
    auto bytes = run(encoder);
    if (!bytes) return bytes.error();
    if (!best || bytes->size() < best->size()) best = std::move(bytes).value();
  }
  return finish(std::move(*best), 2, glm::dvec3(0));
}

const char* dracoVersion() { return draco::kDracoVersion; }

}  // namespace foreland::lab
