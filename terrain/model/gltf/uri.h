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

// The name of a file, relative to the model's folder, that a URI stands for. Error: a URI of the network, an absolute
// path or one that leaves the folder, because a model from a stranger must not read other files.
[[nodiscard]] Result<std::string> fileOfUri(std::string_view uri);

}  // namespace foreland::terrain
