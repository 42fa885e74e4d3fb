#include "terrain/model/read_model.h"

#include <algorithm>
#include <cctype>
#include <fstream>
#include <system_error>

namespace foreland::terrain {

namespace {

namespace fs = std::filesystem;

Result<Bytes> readFile(const fs::path& path) {
  std::error_code failed;
  if (!fs::exists(path, failed)) return Error{ErrorCode::kNotFound, path.string() + ": there is no such file"};
  if (!fs::is_regular_file(path, failed))
    return Error{ErrorCode::kInvalidArgument, path.string() + ": not a file; name an .obj or .ply model"};
  const uint64_t size = fs::file_size(path, failed);
  if (failed) return Error{ErrorCode::kIo, path.string() + ": " + failed.message()};
  if (size > kMaxModelBytes) return Error{ErrorCode::kLimit, path.string() + ": larger than 8 GiB; simplify the model"};
  Bytes bytes(size);
  std::ifstream in(path, std::ios::binary);
  in.read(reinterpret_cast<char*>(bytes.data()), static_cast<std::streamsize>(size));
  if (!in) return Error{ErrorCode::kIo, path.string() + ": cannot be read"};
  return bytes;
}

}  // namespace

Result<Model> readModel(const fs::path& path) {
  std::string suffix = path.extension().string();
  std::transform(suffix.begin(), suffix.end(), suffix.begin(), [](unsigned char c) { return std::tolower(c); });
  if (suffix != ".obj" && suffix != ".ply")
    return Error{ErrorCode::kUnsupported, path.string() + ": neither .obj nor .ply; export the model as one of these"};
  const auto bytes = readFile(path);
  if (!bytes.ok()) return bytes.error();
  const fs::path folder = path.parent_path();
  const auto text = std::string_view(reinterpret_cast<const char*>(bytes->data()), bytes->size());
  auto model = suffix == ".ply"
                   ? parsePly(*bytes, path.string())
                   : parseObj(text, path.string(), [&](const std::string& name) { return readFile(folder / name); });
  if (!model.ok()) return model;
  for (Material& material : model->materials)
    if (!material.texture.empty()) material.texture = folder / material.texture;
  return model;
}

}  // namespace foreland::terrain
