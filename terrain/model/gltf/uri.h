// What the URIs of a glTF file name: data within the file, or a file in the model's folder. Pure; any thread.
#pragma once

#include <string>
#include <string_view>

#include "base/bytes.h"
#include "base/result.h"

namespace foreland::terrain {

[[nodiscard]] bool isDataUri(std::string_view uri);

// The bytes of a base64 data URI. Error: another encoding, or broken base64.
[[nodiscard]] Result<Bytes> decodeDataUri(std::string_view uri);

// The name of a file that a URI stands for, with forward slashes. Whether the model may name it is for the caller to
// decide (neighbours.h). Error: an empty name, or one with a zero byte.
[[nodiscard]] Result<std::string> fileOfUri(std::string_view uri);

}  // namespace foreland::terrain
