// The triangles of one primitive of a glTF mesh, from plain or compressed data. Pure; any thread.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "base/result.h"
#include "terrain/model/gltf/buffers.h"
#include "terrain/model/gltf/document.h"

namespace foreland::terrain {

struct GltfTriangles {
  std::vector<double> positions;               // x, y, z
  std::vector<double> texture_coordinates;     // u, v; empty if the material has no image
  std::vector<double> colours;                 // linear red, green, blue, alpha; may be empty
  std::vector<std::array<uint32_t, 3>> faces;  // each corner in range
  size_t count() const { return positions.size() / 3; }
};

// `coordinates` is the set of texture coordinates that is wanted, kNoIndex for none. Errors name what is wrong, but
// neither the file nor the primitive. `primitive` has triangles (isOfTriangles).
[[nodiscard]] Result<GltfTriangles> readPrimitive(const GltfDocument& document, const GltfPrimitive& primitive,
                                                  uint32_t coordinates, GltfBuffers& buffers);

// Not points or lines.
[[nodiscard]] bool isOfTriangles(const GltfPrimitive& primitive);

}  // namespace foreland::terrain
