// What another program is to read. Any thread.
#pragma once

#include <filesystem>

#include "base/bytes.h"
#include "base/result.h"

namespace foreland::lab {

// kIo, with what to do, if the file cannot be written.
Status writeFile(ByteSpan bytes, const std::filesystem::path& path);

}  // namespace foreland::lab
