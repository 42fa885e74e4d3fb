#include "lab/programs/write_file.h"

#include <fstream>

namespace foreland::lab {

Status writeFile(ByteSpan bytes, const std::filesystem::path& path) {
  std::ofstream file(path, std::ios::binary);
  file.write(reinterpret_cast<const char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
  file.close();
  if (file) return {};
  return Error{ErrorCode::kIo, path.string() + ": cannot be written; free some space, or set TMPDIR to where there is"};
}

}  // namespace foreland::lab
