// Unpacks what EXT_meshopt_compression has packed, by meshoptimizer, which no other file of the product uses. Pure; any
// thread.
#pragma once

#include "base/bytes.h"
#include "base/result.h"
#include "terrain/model/gltf/document.h"

namespace foreland::terrain {

// count x stride bytes. Error, without the file's name: an unknown mode or filter, a stride that it cannot have, more
// elements than the bytes can stand for, broken data.
[[nodiscard]] Result<Bytes> unpackMeshopt(const GltfMeshopt& packed, ByteSpan bytes);

}  // namespace foreland::terrain
