#include "lab/wire/peers/meshoptimizer_peer.h"

#include <meshoptimizer.h>
#include <zstd.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <string>

#include "base/check.h"
#include "lab/wire/peers/meshoptimizer_order.h"

namespace foreland::lab {

namespace {

constexpr double kLargest = (1 << kMeshoptimizerBits) - 1;

// The vertex codec wants a multiple of four bytes.
template <class Number>
struct Vertex {
  std::array<Number, 3> at;
  Number unused = 0;
};

struct Header {
  glm::dvec3 origin;
  double step;
  uint32_t vertices, indices, vertex_bytes, index_bytes;
  uint32_t number_bytes;  // of a coordinate: 2 or 4
};

Header headerFor(const PeerMesh& mesh) {
  return {.origin = boxAround(mesh).low,
          .step = 1,
          .vertices = static_cast<uint32_t>(mesh.positions.size()),
          .indices = static_cast<uint32_t>(mesh.indices.size()),
          .vertex_bytes = 0,
          .index_bytes = 0,
          .number_bytes = 2};
}

double longestSide(const PeerMesh& mesh) {
  const Box box = boxAround(mesh);
  const glm::dvec3 extent = box.high - box.low;
  return std::max({extent.x, extent.y, extent.z, 1e-12});
}

template <class Number>
Bytes encodeVertices(const std::vector<glm::dvec3>& positions, const Header& header) {
  std::vector<Vertex<Number>> vertices(positions.size());
  for (size_t i = 0; i < positions.size(); ++i)
    for (int axis = 0; axis < 3; ++axis)
      vertices[i].at[static_cast<size_t>(axis)] =
          static_cast<Number>(std::lround((positions[i][axis] - header.origin[axis]) / header.step));
  Bytes code(meshopt_encodeVertexBufferBound(vertices.size(), sizeof(vertices[0])));
  code.resize(
      meshopt_encodeVertexBuffer(code.data(), code.size(), vertices.data(), vertices.size(), sizeof(vertices[0])));
  return code;
}

template <class Number>
bool decodeVertices(ByteSpan code, const Header& header, PeerMesh& mesh) {
  std::vector<Vertex<Number>> vertices(header.vertices);
  if (meshopt_decodeVertexBuffer(vertices.data(), vertices.size(), sizeof(vertices[0]), code.data(), code.size()) != 0)
    return false;
  for (const auto& v : vertices)
    mesh.positions.push_back(header.origin + header.step * glm::dvec3(v.at[0], v.at[1], v.at[2]));
  return true;
}

Bytes encode(const PeerMesh& mesh, Header header) {
  const Bytes vertex_code = header.number_bytes == 2 ? encodeVertices<uint16_t>(mesh.positions, header)
                                                     : encodeVertices<uint32_t>(mesh.positions, header);
  Bytes index_code(meshopt_encodeIndexBufferBound(mesh.indices.size(), mesh.positions.size()));
  index_code.resize(
      meshopt_encodeIndexBuffer(index_code.data(), index_code.size(), mesh.indices.data(), mesh.indices.size()));
  header.vertex_bytes = static_cast<uint32_t>(vertex_code.size());
  header.index_bytes = static_cast<uint32_t>(index_code.size());
  Bytes plain;
  ByteWriter w(plain);
  w.put(header);
  w.putBytes(vertex_code);
  w.putBytes(index_code);
  Bytes out(ZSTD_compressBound(plain.size()));
  const size_t size = ZSTD_compress(out.data(), out.size(), plain.data(), plain.size(), kMeshoptimizerZstdLevel);
  CHECK_TRUE(ZSTD_isError(size) == 0);
  out.resize(size);
  return out;
}

Error unreadable(const std::string& what) { return {ErrorCode::kMalformed, "meshoptimizer: " + what}; }

Result<PeerMesh> decode(ByteSpan bytes) {
  const unsigned long long size = ZSTD_getFrameContentSize(bytes.data(), bytes.size());
  if (size == ZSTD_CONTENTSIZE_UNKNOWN || size == ZSTD_CONTENTSIZE_ERROR || size > size_t{1} << 30)
    return unreadable("no zstd frame");
  Bytes plain(size);
  if (ZSTD_decompress(plain.data(), plain.size(), bytes.data(), bytes.size()) != size) return unreadable("zstd fails");
  ByteReader r(plain);
  const auto header = r.get<Header>();
  const ByteSpan vertex_code = r.getBytes(header.vertex_bytes), index_code = r.getBytes(header.index_bytes);
  if (!r.atEnd()) return unreadable("its parts do not fill it");
  PeerMesh mesh;
  mesh.indices.resize(header.indices);
  const bool has_vertices = header.number_bytes == 2 ? decodeVertices<uint16_t>(vertex_code, header, mesh)
                                                     : decodeVertices<uint32_t>(vertex_code, header, mesh);
  if (!has_vertices || meshopt_decodeIndexBuffer(mesh.indices.data(), mesh.indices.size(), sizeof(uint32_t),
                                                 index_code.data(), index_code.size()) != 0)
    return unreadable("vertices or indices cannot be decoded");
  return mesh;
}

}  // namespace

PeerMesh orderedForVertexCache(const PeerMesh& mesh) {
  PeerMesh out;
  out.indices.resize(mesh.indices.size());
  out.positions.resize(mesh.positions.size());
  meshopt_optimizeVertexCacheStrip(out.indices.data(), mesh.indices.data(), mesh.indices.size(), mesh.positions.size());
  const size_t used = meshopt_optimizeVertexFetch(out.positions.data(), out.indices.data(), out.indices.size(),
                                                  mesh.positions.data(), mesh.positions.size(), sizeof(glm::dvec3));
  CHECK_EQ(used, mesh.positions.size());
  return out;
}

namespace {

Result<PeerCode> code(const PeerMesh& mesh, const Header& header, double tolerance) {
  PeerCode code{
      .bytes = encode(orderedForVertexCache(mesh), header), .decoded = {}, .tolerance = glm::dvec3(tolerance)};
  auto decoded = decode(code.bytes);
  if (!decoded) return decoded.error();
  code.decoded = std::move(decoded).value();
  return code;
}

}  // namespace

Result<PeerCode> codeMeshoptimizer(const PeerMesh& mesh) {
  Header header = headerFor(mesh);
  header.step = longestSide(mesh) / kLargest;
  return code(mesh, header, 0.5 * header.step * 1.000001);
}

Result<PeerCode> codeMeshoptimizerExactly(const PeerMesh& mesh) {
  for (const glm::dvec3& p : mesh.positions)
    for (int k = 0; k < 3; ++k) CHECK_EQ(p[k], static_cast<double>(static_cast<int32_t>(p[k])));
  Header header = headerFor(mesh);
  if (longestSide(mesh) > kLargest) header.number_bytes = 4;
  return code(mesh, header, 0);
}

std::string meshoptimizerVersion() {
  return std::to_string(MESHOPTIMIZER_VERSION / 1000) + "." + std::to_string(MESHOPTIMIZER_VERSION % 1000 / 10);
}

}  // namespace foreland::lab
