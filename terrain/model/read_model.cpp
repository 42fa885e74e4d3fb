#include "terrain/model/read_model.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <string>

#include "terrain/model/neighbours.h"
#include "terrain/model/read_file.h"
#include "terrain/model/words.h"

namespace foreland::terrain {

namespace {

namespace fs = std::filesystem;

Result<Model> parse(const std::string& suffix, ByteSpan bytes, const fs::path& path, Neighbours& neighbours) {
  const std::string name = path.string();
  if (suffix == ".ply") return parsePly(bytes, name);
  if (suffix == ".stl") return parseStl(bytes, name);
  const auto neighbour = [&](const std::string& file) -> Result<Bytes> {
    const auto found = neighbours.find(file, path);
    if (!found.ok()) return found.error();
    return readFile(*found);
  };
  if (suffix == ".glb" || suffix == ".gltf") return parseGltf(bytes, name, neighbour);
  return parseObj({reinterpret_cast<const char*>(bytes.data()), bytes.size()}, name, neighbour);
}

// A texture that is not found is a note, and the material's colour is used.
void findTexture(const fs::path& path, Neighbours& neighbours, Material& material, Model& model) {
  if (material.texture.empty() || material.embedded) return;
  fs::path namer = path;
  if (!material.library.empty())
    if (const auto library = neighbours.find(material.library, path); library.ok()) namer = *library;
  const std::string written = material.texture.string();
  Result<fs::path> found = fs::path();
  for (const std::string_view name : possibleNames(written))
    if (found = neighbours.find(std::string(name), namer); found.ok()) break;
  if (!found.ok())
    model.notes.push_back("without the texture of material '" + material.name + "': " + found.error().message);
  material.texture = found.ok() ? std::move(found).value() : fs::path();
}

}  // namespace

Result<Model> readModel(const fs::path& path, const std::vector<fs::path>& allowed) {
  std::string suffix = path.extension().string();
  std::transform(suffix.begin(), suffix.end(), suffix.begin(), [](unsigned char c) { return std::tolower(c); });
  constexpr std::array kSuffixes{".obj", ".ply", ".stl", ".glb", ".gltf"};
  if (std::find(kSuffixes.begin(), kSuffixes.end(), suffix) == kSuffixes.end())
    return Error{ErrorCode::kUnsupported,
                 path.string() + ": not one of .obj, .ply, .stl, .glb and .gltf; export the model as one of these"};
  const auto bytes = readFile(path);
  if (!bytes.ok()) return bytes.error();
  Neighbours neighbours(path, allowed);
  auto model = parse(suffix, *bytes, path, neighbours);
  if (!model.ok()) return model;
  for (Material& material : model->materials) findTexture(path, neighbours, material, *model);
  return model;
}

}  // namespace foreland::terrain
