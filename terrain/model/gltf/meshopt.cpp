#include "terrain/model/gltf/meshopt.h"

#include <meshoptimizer.h>

#include <string>
#include <utility>

namespace foreland::terrain {

namespace {

// The codec needs at least 4 bytes for 256 vertices of each byte of the stride, and a byte for an index.
constexpr uint64_t kMaxShrunk = 64;

Error refusedMeshopt(std::string what) {
  return {ErrorCode::kMalformed, "has meshopt data " + std::move(what) + "; export the model again"};
}

Status checkStride(const GltfMeshopt& p) {
  const bool is_vertices = p.mode == "ATTRIBUTES";
  const bool fits_mode = is_vertices ? p.stride > 0 && p.stride % 4 == 0 && p.stride <= 256
                                     : (p.stride == 2 || p.stride == 4) && (p.mode != "TRIANGLES" || p.count % 3 == 0);
  const bool fits_filter = p.filter.empty() || p.filter == "NONE" ||
                           (is_vertices && ((p.filter == "OCTAHEDRAL" && (p.stride == 4 || p.stride == 8)) ||
                                            (p.filter == "QUATERNION" && p.stride == 8) || p.filter == "EXPONENTIAL"));
  if (fits_mode && fits_filter) return {};
  return refusedMeshopt("of the mode '" + p.mode.substr(0, 20) + "', the filter '" + p.filter.substr(0, 20) + "', " +
                        std::to_string(p.count) + " elements and " + std::to_string(p.stride) +
                        " bytes each, which do not go together");
}

int decodeMeshopt(const GltfMeshopt& p, ByteSpan bytes, Bytes& out) {
  if (p.mode == "ATTRIBUTES")
    return meshopt_decodeVertexBuffer(out.data(), p.count, p.stride, bytes.data(), bytes.size());
  if (p.mode == "TRIANGLES")
    return meshopt_decodeIndexBuffer(out.data(), p.count, p.stride, bytes.data(), bytes.size());
  return meshopt_decodeIndexSequence(out.data(), p.count, p.stride, bytes.data(), bytes.size());
}

void applyFilter(const GltfMeshopt& p, Bytes& out) {
  if (p.filter == "OCTAHEDRAL") meshopt_decodeFilterOct(out.data(), p.count, p.stride);
  if (p.filter == "QUATERNION") meshopt_decodeFilterQuat(out.data(), p.count, p.stride);
  if (p.filter == "EXPONENTIAL") meshopt_decodeFilterExp(out.data(), p.count, p.stride);
}

}  // namespace

Result<Bytes> unpackMeshopt(const GltfMeshopt& packed, ByteSpan bytes) {
  if (packed.mode != "ATTRIBUTES" && packed.mode != "TRIANGLES" && packed.mode != "INDICES")
    return refusedMeshopt("of the unknown mode '" + packed.mode.substr(0, 20) + "'");
  if (Status status = checkStride(packed); !status.ok()) return status.error();
  if (packed.count > kMaxModelVertices * 3 || packed.count * packed.stride / kMaxShrunk > bytes.size())
    return refusedMeshopt("that promises " + std::to_string(packed.count) + " elements, more than its bytes can hold");
  Bytes out(packed.count * packed.stride);
  if (packed.count == 0) return out;
  if (decodeMeshopt(packed, bytes, out) != 0) return refusedMeshopt("that is damaged");
  applyFilter(packed, out);
  return out;
}

}  // namespace foreland::terrain
