// Reads a polygon model: Wavefront OBJ (polygons, texture coordinates, mtllib and map_Kd, colours behind the vertices),
// PLY (ascii and both binary orders, colours of vertices and faces, texture coordinates by vertex and by corner,
// "comment TextureFile"), STL (ascii and binary, colours of faces; vertices at the same position become one, because
// STL repeats them at each face) or glTF 2.0 (.glb and .gltf, all nodes of its scene; Draco, meshopt, quantised; base
// colours; skins and morphs as they rest). Any bytes end in a Model or an Error that names the file, its line or
// element, and the remedy; every count is checked against the number of bytes that follow before memory is allocated
// for it. Text may have a byte-order mark, be UTF-16 and have any line ends (base/utf8.h, base/lines.h). What is not
// taken is a note with its count. Textures are only found (neighbours.h), not read. Pure but for the files; any thread.
// Cost: linear in the file, which is held in memory meanwhile.
#pragma once

#include <filesystem>
#include <functional>
#include <string_view>
#include <vector>

#include "base/bytes.h"
#include "base/result.h"
#include "terrain/model/model.h"

namespace foreland::terrain {

// Reads a file; the suffix of its name, .obj, .ply, .stl, .glb or .gltf, says which kind it is. Files that it names
// must lie in its folder or in those of `allowed`; one of glTF's buffers that does not is an Error, others are notes.
[[nodiscard]] Result<Model> readModel(const std::filesystem::path& path,
                                      const std::vector<std::filesystem::path>& allowed = {});

// The same from memory; messages use `name`. `library` returns the text of the file that `mtllib` names. A material
// library that cannot be read is no error but a note: the model's shape does not depend on it.
using FileReader = std::function<Result<Bytes>(const std::string& name)>;
[[nodiscard]] Result<Model> parseObj(std::string_view text, const std::string& name, const FileReader& library);
[[nodiscard]] Result<Model> parsePly(ByteSpan bytes, const std::string& name);
[[nodiscard]] Result<Model> parseStl(ByteSpan bytes, const std::string& name);
// `read_file` returns the bytes of a file that the model names, and decides whether the model may name it.
[[nodiscard]] Result<Model> parseGltf(ByteSpan bytes, const std::string& name, const FileReader& read_file);

}  // namespace foreland::terrain
