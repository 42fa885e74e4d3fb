#include "terrain/model/read_file.h"

#include <fstream>
#include <string>
#include <system_error>

#include "terrain/model/model.h"

namespace foreland::terrain {

Result<Bytes> readFile(const std::filesystem::path& path) {
  std::error_code failed;
  if (!std::filesystem::exists(path, failed))
    return Error{ErrorCode::kNotFound, path.string() + ": there is no such file"};
  if (!std::filesystem::is_regular_file(path, failed))
    return Error{ErrorCode::kInvalidArgument, path.string() + ": not a file; name a model's file"};
  const uint64_t size = std::filesystem::file_size(path, failed);
  if (failed) return Error{ErrorCode::kIo, path.string() + ": " + failed.message()};
  if (size > kMaxModelBytes) return Error{ErrorCode::kLimit, path.string() + ": larger than 8 GiB; simplify the model"};
  Bytes bytes(size);
  std::ifstream in(path, std::ios::binary);
  in.read(reinterpret_cast<char*>(bytes.data()), static_cast<std::streamsize>(size));
  if (!in) return Error{ErrorCode::kIo, path.string() + ": cannot be read"};
  return bytes;
}

}  // namespace foreland::terrain
