// The header of a PLY file: which elements with which properties follow, in which form. Any text ends in a PlyHeader or
// an Error. Pure; any thread.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "base/result.h"

namespace foreland::terrain {

enum class PlyType : uint8_t { kInt8, kUint8, kInt16, kUint16, kInt32, kUint32, kFloat, kDouble };
enum class PlyForm : uint8_t { kAscii, kLittleEndian, kBigEndian };

struct PlyProperty {
  std::string name;
  PlyType type = PlyType::kFloat;
  bool is_list = false;
  PlyType count_type = PlyType::kUint8;  // of lists
};

struct PlyElement {
  std::string name;
  uint64_t count = 0;
  std::vector<PlyProperty> properties;
};

struct PlyHeader {
  PlyForm form = PlyForm::kAscii;
  std::vector<PlyElement> elements;
  std::vector<std::string> textures;  // of "comment TextureFile"
  size_t bytes = 0;                   // of the header: what follows is the data
};

[[nodiscard]] Result<PlyHeader> parsePlyHeader(std::string_view text);

size_t plyTypeBytes(PlyType type);

}  // namespace foreland::terrain
