// Unpacks what KHR_draco_mesh_compression has packed, by Draco, which no other file of the product uses. Pure; any
// thread.
#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "base/bytes.h"
#include "base/result.h"

namespace foreland::terrain {

struct DracoMesh {
  std::vector<std::array<uint32_t, 3>> faces;
  std::map<std::string, std::vector<double>> attributes;  // the components of one point after those of another
  std::map<std::string, uint32_t> components;             // of each attribute
};

// `attributes`: the names that are wanted, and their ids in the packed mesh. Error, without the file's name: damaged
// data, or an attribute that is not there.
[[nodiscard]] Result<DracoMesh> unpackDraco(ByteSpan bytes, const std::map<std::string, uint32_t>& attributes);

}  // namespace foreland::terrain
