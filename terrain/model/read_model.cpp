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
    return Error{ErrorCode::kInvalidArgument, path.string() + ": not a file; name a model's file"};
  const uint64_t size = fs::file_size(path, failed);
  if (failed) return Error{ErrorCode::kIo, path.string() + ": " + failed.message()};
  if (size > kMaxModelBytes) return Error{ErrorCode::kLimit, path.string() + ": larger than 8 GiB; simplify the model"};
  Bytes bytes(size);
  std::ifstream in(path, std::ios::binary);
  in.read(reinterpret_cast<char*>(bytes.data()), static_cast<std::streamsize>(size));
  if (!in) return Error{ErrorCode::kIo, path.string() + ": cannot be read"};
  return bytes;
}

Result<Model> parse(const std::string& suffix, ByteSpan bytes, const fs::path& path) {
  const std::string name = path.string();
  if (suffix == ".ply") return parsePly(bytes, name);
  if (suffix == ".stl") return parseStl(bytes, name);
  const auto library = [&](const std::string& file) { return readFile(path.parent_path() / file); };
  return parseObj({reinterpret_cast<const char*>(bytes.data()), bytes.size()}, name, library);
}

}  // namespace

Result<Model> readModel(const fs::path& path) {
  std::string suffix = path.extension().string();
  std::transform(suffix.begin(), suffix.end(), suffix.begin(), [](unsigned char c) { return std::tolower(c); });
  if (suffix != ".obj" && suffix != ".ply" && suffix != ".stl")
    return Error{ErrorCode::kUnsupported,
                 path.string() + ": not one of .obj, .ply and .stl; export the model as one of these"};
  const auto bytes = readFile(path);
  if (!bytes.ok()) return bytes.error();
  const fs::path folder = path.parent_path();
  auto model = parse(suffix, *bytes, path);
  if (!model.ok()) return model;
  for (Material& material : model->materials)
    if (!material.texture.empty()) material.texture = folder / material.texture;
  return model;
}

}  // namespace foreland::terrain
