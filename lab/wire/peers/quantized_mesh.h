// Cesium's quantized-mesh-1.0, as terrain servers send it, and gzip around it. Written from the format's description;
// judged by a decoder that others made (npm @here/quantized-mesh-decoder, run by node), since npm has no encoder.
//
// Vertices are 16-bit integers, 0 to 32767 over the mesh's box along each axis (heights over the range that the header
// states), coded as zigzag differences; triangle indices relative to the highest yet used; no extensions. The mesh is
// one tile; its triangles are ordered as strips and its vertices by first use, which the format asks for and gzip
// likes. The header's fields in Earth-centred coordinates hold the mesh's own: they are 88 bytes whatever is
// in them.
//
// Blocks; any thread.
#pragma once

#include <filesystem>

#include "base/result.h"
#include "lab/wire/peers/peer_mesh.h"

namespace foreland::lab {

inline constexpr int kQuantizedMeshMax = 32767;

// A .terrain file, not yet compressed. The mesh is not empty.
Bytes encodeQuantizedMesh(const PeerMesh& mesh);

// zlib's gzip at level 9.
Bytes gzip(ByteSpan bytes);

// Where decode.mjs lies.
std::filesystem::path quantizedMeshSources();

// Encodes, compresses, and lets the package in `folder` (decode.mjs and node_modules) decode. kNotFound, with the way
// out, if node or the package is missing; kMalformed if the package makes nothing of the bytes.
Result<PeerCode> codeQuantizedMesh(const PeerMesh& mesh, const std::filesystem::path& folder);

}  // namespace foreland::lab
