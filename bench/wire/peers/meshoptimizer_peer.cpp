#include "bench/wire/peers/meshoptimizer_peer.h"

#include <meshoptimizer.h>
#include <zstd.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <string>

#include "base/check.h"
#include "bench/wire/peers/meshoptimizer_order.h"

namespace foreland::bench {

namespace {

constexpr double kLargest = (1 << kMeshoptimizerBits) - 1;

// The vertex codec wants a multiple of four bytes.
struct Vertex {
  std::array<uint16_t, 3> at;
  uint16_t unused = 0;
};
static_assert(sizeof(Vertex) == 8);

struct Header {
  glm::dvec3 origin;
  double step;
  uint32_t vertices, indices, vertex_bytes, index_bytes;
};

Header headerFor(const PeerMesh& mesh) {
  const Box box = boxAround(mesh);
  const glm::dvec3 extent = box.high - box.low;
  return {.origin = box.low,
          .step = std::max({extent.x, extent.y, extent.z, 1e-12}) / kLargest,
          .vertices = static_cast<uint32_t>(mesh.positions.size()),
          .indices = static_cast<uint32_t>(mesh.indices.size()),
          .vertex_bytes = 0,
          .index_bytes = 0};
}

std::vector<Vertex> quantize(const std::vector<glm::dvec3>& positions, const Header& header) {
  std::vector<Vertex> out(positions.size());
  for (size_t i = 0; i < positions.size(); ++i)
    for (int axis = 0; axis < 3; ++axis)
      out[i].at[static_cast<size_t>(axis)] =
          static_cast<uint16_t>(std::lround((positions[i][axis] - header.origin[axis]) / header.step));
  return out;
}

Bytes encode(const PeerMesh& mesh, Header header) {
  const std::vector<Vertex> vertices = quantize(mesh.positions, header);
  Bytes vertex_code(meshopt_encodeVertexBufferBound(vertices.size(), sizeof(Vertex)));
  vertex_code.resize(meshopt_encodeVertexBuffer(vertex_code.data(), vertex_code.size(), vertices.data(),
                                                vertices.size(), sizeof(Vertex)));
  Bytes index_code(meshopt_encodeIndexBufferBound(mesh.indices.size(), vertices.size()));
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
  std::vector<Vertex> vertices(header.vertices);
  PeerMesh mesh;
  mesh.indices.resize(header.indices);
  if (meshopt_decodeVertexBuffer(vertices.data(), vertices.size(), sizeof(Vertex), vertex_code.data(),
                                 vertex_code.size()) != 0 ||
      meshopt_decodeIndexBuffer(mesh.indices.data(), mesh.indices.size(), sizeof(uint32_t), index_code.data(),
                                index_code.size()) != 0)
    return unreadable("vertices or indices cannot be decoded");
  for (const Vertex& v : vertices)
    mesh.positions.push_back(header.origin + header.step * glm::dvec3(v.at[0], v.at[1], v.at[2]));
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

Result<PeerCode> codeMeshoptimizer(const PeerMesh& mesh) {
  const Header header = headerFor(mesh);
  PeerCode code{.bytes = encode(orderedForVertexCache(mesh), header),
                .decoded = {},
                .tolerance = glm::dvec3(0.5 * header.step * 1.000001)};
  auto decoded = decode(code.bytes);
  if (!decoded) return decoded.error();
  code.decoded = std::move(decoded).value();
  return code;
}

std::string meshoptimizerVersion() {
  return std::to_string(MESHOPTIMIZER_VERSION / 1000) + "." + std::to_string(MESHOPTIMIZER_VERSION % 1000 / 10);
}

}  // namespace foreland::bench
