// Reads a polygon model: Wavefront OBJ (polygons, texture coordinates, mtllib and map_Kd, colours behind the vertices),
// PLY (ascii and both binary orders, colours, texture coordinates by vertex, "comment TextureFile"), STL (ascii and
// binary; vertices at the same position become one, because STL repeats them at each face) or glTF 2.0 (.glb and .gltf,
// all nodes of its scene; Draco, meshopt, quantised; base colours; skins and morphs as they rest). Any bytes end
// in a Model or an Error that names the file, its line or element, and the remedy; every count is checked against the
// number of bytes that follow before memory is allocated for it. Textures are only named, not read. Pure but for the
// files; any thread. Cost: linear in the file, which is held in memory meanwhile.
#pragma once

#include <filesystem>
#include <functional>
#include <string_view>

#include "base/bytes.h"
#include "base/result.h"
#include "terrain/model/model.h"

namespace foreland::terrain {

// Reads a file; the suffix of its name, .obj, .ply, .stl, .glb or .gltf, says which kind it is.
[[nodiscard]] Result<Model> readModel(const std::filesystem::path& path);

// The same from memory; messages use `name`. `library` returns the text of the file that `mtllib` names. A material
// library that cannot be read is no error but leaves the model without materials: its shape does not depend on them.
using FileReader = std::function<Result<Bytes>(const std::string& name)>;
[[nodiscard]] Result<Model> parseObj(std::string_view text, const std::string& name, const FileReader& library);
[[nodiscard]] Result<Model> parsePly(ByteSpan bytes, const std::string& name);
[[nodiscard]] Result<Model> parseStl(ByteSpan bytes, const std::string& name);
// `read_file` returns the bytes of a file in the model's folder; names that leave it are refused before.
[[nodiscard]] Result<Model> parseGltf(ByteSpan bytes, const std::string& name, const FileReader& read_file);

}  // namespace foreland::terrain
