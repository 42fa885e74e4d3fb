#include "terrain/model/read_model.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <string>

#include "terrain/model/read_file.h"

namespace foreland::terrain {

namespace {

namespace fs = std::filesystem;

Result<Model> parse(const std::string& suffix, ByteSpan bytes, const fs::path& path) {
  const std::string name = path.string();
  if (suffix == ".ply") return parsePly(bytes, name);
  if (suffix == ".stl") return parseStl(bytes, name);
  const auto neighbour = [&](const std::string& file) { return readFile(path.parent_path() / file); };
  if (suffix == ".glb" || suffix == ".gltf") return parseGltf(bytes, name, neighbour);
  return parseObj({reinterpret_cast<const char*>(bytes.data()), bytes.size()}, name, neighbour);
}

}  // namespace

Result<Model> readModel(const fs::path& path) {
  std::string suffix = path.extension().string();
  std::transform(suffix.begin(), suffix.end(), suffix.begin(), [](unsigned char c) { return std::tolower(c); });
  constexpr std::array kSuffixes{".obj", ".ply", ".stl", ".glb", ".gltf"};
  if (std::find(kSuffixes.begin(), kSuffixes.end(), suffix) == kSuffixes.end())
    return Error{ErrorCode::kUnsupported,
                 path.string() + ": not one of .obj, .ply, .stl, .glb and .gltf; export the model as one of these"};
  const auto bytes = readFile(path);
  if (!bytes.ok()) return bytes.error();
  const fs::path folder = path.parent_path();
  auto model = parse(suffix, *bytes, path);
  if (!model.ok()) return model;
  for (Material& material : model->materials)
    if (!material.texture.empty() && !material.embedded) material.texture = folder / material.texture;
  return model;
}

}  // namespace foreland::terrain
