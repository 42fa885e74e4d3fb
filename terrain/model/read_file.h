// Reads whole files of models. Any thread.
#pragma once

#include <filesystem>

#include "base/bytes.h"
#include "base/result.h"

namespace foreland::terrain {

// Error, with the file's name: there is none, it is no file, it is larger than kMaxModelBytes, it cannot be read.
[[nodiscard]] Result<Bytes> readFile(const std::filesystem::path& path);

}  // namespace foreland::terrain
