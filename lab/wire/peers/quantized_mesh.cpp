#include "lab/wire/peers/quantized_mesh.h"

#include <zlib.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <fstream>
#include <glm/geometric.hpp>
#include <iterator>

#include "base/check.h"
#include "lab/programs/lab_folder.h"
#include "lab/programs/run_program.h"
#include "lab/programs/temporary_folder.h"
#include "lab/programs/write_file.h"
#include "lab/wire/peers/meshoptimizer_order.h"

namespace foreland::lab {

namespace {

namespace fs = std::filesystem;

constexpr size_t kMaxShortIndices = 65536;  // more vertices take indices of 32 bits

using Quantized = std::array<uint16_t, 3>;

std::vector<Quantized> quantize(const std::vector<glm::dvec3>& positions, const Box& box) {
  std::vector<Quantized> out(positions.size());
  for (size_t i = 0; i < positions.size(); ++i)
    for (int axis = 0; axis < 3; ++axis) {
      const double extent = box.high[axis] - box.low[axis];
      const double u = extent > 0 ? (positions[i][axis] - box.low[axis]) / extent : 0;
      out[i][static_cast<size_t>(axis)] = static_cast<uint16_t>(std::lround(u * kQuantizedMeshMax));
    }
  return out;
}

// Centre, range of heights, bounding sphere, horizon occlusion point.
void putHeader(const Box& box, ByteWriter& w) {
  const glm::dvec3 centre = 0.5 * (box.low + box.high);
  w.put(centre);
  w.put(static_cast<float>(box.low.z));
  w.put(static_cast<float>(box.high.z));
  w.put(centre);
  w.put(0.5 * glm::distance(box.low, box.high));
  w.put(centre);
}

void putVertices(const std::vector<Quantized>& vertices, ByteWriter& w) {
  w.put(static_cast<uint32_t>(vertices.size()));
  for (size_t axis = 0; axis < 3; ++axis) {
    int last = 0;
    for (const Quantized& v : vertices) {
      const int step = v[axis] - last;
      w.put(static_cast<uint16_t>((step << 1) ^ (step >> 31)));
      last = v[axis];
    }
  }
}

template <class Index>
void putIndices(const std::vector<uint32_t>& indices, ByteWriter& w) {
  w.put(static_cast<uint32_t>(indices.size() / 3));
  uint32_t highest = 0;
  for (uint32_t index : indices) {
    const uint32_t code = highest - index;
    w.put(static_cast<Index>(code));
    if (code == 0) ++highest;
  }
}

// The vertices on one side of the tile: those whose `axis` is `value`.
template <class Index>
void putEdge(const std::vector<Quantized>& vertices, size_t axis, int value, ByteWriter& w) {
  const auto on_it = [&](const Quantized& v) { return v[axis] == value; };
  w.put(static_cast<uint32_t>(std::count_if(vertices.begin(), vertices.end(), on_it)));
  for (size_t i = 0; i < vertices.size(); ++i)
    if (on_it(vertices[i])) w.put(static_cast<Index>(i));
}

template <class Index>
void putTopology(const PeerMesh& mesh, const std::vector<Quantized>& vertices, Bytes& out) {
  out.resize((out.size() + sizeof(Index) - 1) / sizeof(Index) * sizeof(Index));
  ByteWriter w(out);
  putIndices<Index>(mesh.indices, w);
  putEdge<Index>(vertices, 0, 0, w);                  // west
  putEdge<Index>(vertices, 1, 0, w);                  // south
  putEdge<Index>(vertices, 0, kQuantizedMeshMax, w);  // east
  putEdge<Index>(vertices, 1, kQuantizedMeshMax, w);  // north
}

Error unreadable() { return {ErrorCode::kMalformed, "decode.mjs wrote what is no mesh"}; }

// What decode.mjs wrote: counts, the header's heights, then u, v and height of all vertices, then the indices.
Result<PeerMesh> readDecoded(const fs::path& path, const Box& box) {
  std::ifstream file(path, std::ios::binary);
  const Bytes bytes((std::istreambuf_iterator<char>(file)), {});
  ByteReader r(bytes);
  const auto vertices = r.get<uint32_t>(), indices = r.get<uint32_t>();
  const auto lowest = r.get<double>(), highest = r.get<double>();
  if (!r.ok() || r.remaining() != 6 * size_t{vertices} + 4 * size_t{indices}) return unreadable();
  const glm::dvec3 low(box.low.x, box.low.y, lowest), high(box.high.x, box.high.y, highest);
  PeerMesh mesh;
  mesh.positions.resize(vertices);
  for (int axis = 0; axis < 3; ++axis)
    for (glm::dvec3& p : mesh.positions)
      p[axis] = low[axis] + r.get<uint16_t>() * (high[axis] - low[axis]) / kQuantizedMeshMax;
  mesh.indices.resize(indices);
  for (uint32_t& index : mesh.indices) index = r.get<uint32_t>();
  return mesh;
}

}  // namespace

fs::path quantizedMeshSources() { return labFolder() / "wire/peers"; }

Bytes encodeQuantizedMesh(const PeerMesh& mesh) {
  const PeerMesh ordered = orderedForVertexCache(mesh);
  const Box box = boxAround(mesh);
  const std::vector<Quantized> vertices = quantize(ordered.positions, box);
  Bytes out;
  ByteWriter w(out);
  putHeader(box, w);
  putVertices(vertices, w);
  if (vertices.size() <= kMaxShortIndices)
    putTopology<uint16_t>(ordered, vertices, out);
  else
    putTopology<uint32_t>(ordered, vertices, out);
  return out;
}

Bytes gzip(ByteSpan bytes) {
  constexpr int kGzip = 16 + MAX_WBITS, kLevel = 9, kMemory = 8;
  z_stream stream{};
  CHECK_EQ(deflateInit2(&stream, kLevel, Z_DEFLATED, kGzip, kMemory, Z_DEFAULT_STRATEGY), Z_OK);
  Bytes out(deflateBound(&stream, bytes.size()));
  stream.next_in = const_cast<uint8_t*>(bytes.data());
  stream.avail_in = static_cast<uInt>(bytes.size());
  stream.next_out = out.data();
  stream.avail_out = static_cast<uInt>(out.size());
  CHECK_EQ(deflate(&stream, Z_FINISH), Z_STREAM_END);
  out.resize(stream.total_out);
  deflateEnd(&stream);
  return out;
}

Result<PeerCode> codeQuantizedMesh(const PeerMesh& mesh, const fs::path& folder) {
  const std::string install = "run: npm ci --prefix " + folder.string();
  std::error_code ignored;
  if (!fs::exists(folder / "node_modules/@here/quantized-mesh-decoder/package.json", ignored))
    return Error{ErrorCode::kNotFound, "@here/quantized-mesh-decoder is not installed; " + install};
  const TemporaryFolder scratch;
  if (scratch.path().empty())
    return Error{ErrorCode::kIo, "no temporary folder can be made; set TMPDIR to where one can"};
  const fs::path coded = scratch.path() / "mesh.terrain", decoded = scratch.path() / "mesh.raw";
  const Box box = boxAround(mesh);
  PeerCode code{.bytes = gzip(encodeQuantizedMesh(mesh)), .decoded = {}, .tolerance = {}};
  if (Status s = writeFile(code.bytes, coded); !s.ok()) return s.error();
  const auto printed = runProgram({"node", (folder / "decode.mjs").string(), coded.string(), decoded.string()});
  if (!printed && printed.error().code == ErrorCode::kNotFound)
    return Error{ErrorCode::kNotFound, "node is not installed; install nodejs, then " + install};
  if (!printed) return Error{ErrorCode::kMalformed, "quantized-mesh cannot be decoded: " + printed.error().message};
  auto mesh_again = readDecoded(decoded, box);
  if (!mesh_again) return mesh_again.error();
  code.decoded = std::move(mesh_again).value();
  // Half a step, and what the header's floats lose of the heights.
  code.tolerance = (box.high - box.low) * (0.5 / kQuantizedMeshMax) * 1.000001;
  code.tolerance.z += 1e-7 * std::max(std::fabs(box.low.z), std::fabs(box.high.z));
  return code;
}

}  // namespace foreland::lab
