#include <cmath>
#include <map>

#include "terrain/model/checked_model.h"
#include "terrain/model/read_model.h"
#include "terrain/model/words.h"

namespace foreland::terrain {

namespace {

uint8_t toByte(double share) { return static_cast<uint8_t>(std::lround(std::clamp(share, 0.0, 1.0) * 255)); }

// The file that a `map_Kd` line names: the rest of the line after options, which begin with '-' and have numbers.
std::string textureName(Words words) {
  std::string_view rest = words.rest();
  while (!words.atEnd()) {
    const std::string_view word = words.next();
    const bool is_option = word.front() == '-' || parseNumber<double>(word) || word == "on" || word == "off";
    if (!is_option) break;
    rest = words.rest();
  }
  return std::string(rest);
}

// Materials of one library; lines that are not understood are passed over, as by every reader of these files.
std::vector<Material> parseLibrary(std::string_view text) {
  std::vector<Material> materials;
  Lines lines(text);
  for (std::string_view line; lines.next(line) && materials.size() < kMaxModelMaterials;) {
    Words words(line);
    const std::string_view key = words.next();
    if (key == "newmtl") materials.push_back({std::string(words.rest().substr(0, kMaxModelMaterials)), {}});
    if (materials.empty()) continue;
    if (key == "map_Kd") materials.back().texture = textureName(words);
    if (key == "Kd")
      for (int channel = 0; channel < 3; ++channel)
        if (const auto share = parseNumber<double>(words.next()); share && std::isfinite(*share))
          materials.back().colour[channel] = toByte(*share);
  }
  return materials;
}

class ObjParser {
 public:
  ObjParser(const std::string& name, const FileReader& library) : model_(name, 1), library_(library) {}

  Result<Model> parse(std::string_view text) {
    Lines lines(text);
    std::string joined;
    for (std::string_view line; lines.next(line);) {
      if (!line.empty() && line.back() == '\\') {
        joined.append(line.substr(0, line.size() - 1)) += ' ';
        continue;
      }
      if (!joined.empty()) line = joined.append(line);
      if (Status status = parseLine(line); !status.ok())
        return Error{status.error().code,
                     model_.get().name + ":" + std::to_string(lines.number()) + ": " + status.error().message};
      joined.clear();
    }
    return model_.finish();
  }

 private:
  Status parseLine(std::string_view line) {
    Words words(line.substr(0, line.find('#')));
    const std::string_view key = words.next();
    if (key == "v") return parseVertex(words);
    if (key == "vt") return parseTexture(words);
    if (key == "f") return parseFace(words);
    if (key == "usemtl") return useMaterial(words.rest());
    if (key == "mtllib") return readLibrary(std::string(words.rest()));
    return {};  // normals, groups, lines, curves: not part of the surface
  }

  static Error unreadable(const std::string& what, std::string_view word) {
    return {ErrorCode::kMalformed,
            what + " has '" + std::string(word.substr(0, 40)) + "' where a number belongs; correct or export it again"};
  }

  // x y z, then perhaps w, or r g b.
  Status parseVertex(Words words) {
    double values[7];
    int count = 0;
    for (; count < 7 && !words.atEnd(); ++count) {
      const std::string_view word = words.next();
      const auto value = parseNumber<double>(word);
      if (!value) return unreadable(model_.get().vertexName(model_.get().positions.size()), word);
      values[count] = *value;
    }
    if (count < 3) return unreadable(model_.get().vertexName(model_.get().positions.size()), "");
    if (count >= 6) colourVertex({toByte(values[3]), toByte(values[4]), toByte(values[5]), 255});
    return model_.addPosition({values[0], values[1], values[2]});
  }
  // Vertices before the first coloured one are white.
  void colourVertex(const Colour& colour) {
    auto& colours = model_.edit().colours;
    colours.resize(model_.get().positions.size(), Colour{255, 255, 255, 255});
    colours.push_back(colour);
  }
  Status parseTexture(Words words) {
    const auto u = parseNumber<double>(words.next());
    const auto v = words.atEnd() ? std::optional<double>(0) : parseNumber<double>(words.next());
    if (!u || !v)
      return Error{ErrorCode::kMalformed, "a texture coordinate is no number; correct or export the model again"};
    return model_.addTextureCoordinate({*u, *v});
  }

  // An index as the file has it: from 1, or from the end if negative.
  static std::optional<uint32_t> resolve(std::string_view word, size_t count) {
    const auto index = parseNumber<int64_t>(word);
    if (!index || *index == 0) return std::nullopt;
    const int64_t resolved = *index > 0 ? *index - 1 : static_cast<int64_t>(count) + *index;
    if (resolved < 0 || resolved >= static_cast<int64_t>(kNoIndex)) return std::nullopt;
    return static_cast<uint32_t>(resolved);
  }
  // "vertex", "vertex/texture", "vertex//normal" or "vertex/texture/normal". A face may name vertices that follow
  // it, so whether they exist is checked at the end.
  Status parseFace(Words words) {
    while (!words.atEnd()) {
      const std::string_view word = words.next();
      const size_t slash = std::min(word.find('/'), word.size());
      std::string_view texture = word.substr(std::min(slash + 1, word.size()));
      texture = texture.substr(0, texture.find('/'));
      const auto vertex = resolve(word.substr(0, slash), model_.get().positions.size());
      const auto coordinate = texture.empty() ? std::optional<uint32_t>(kNoIndex)
                                              : resolve(texture, model_.get().texture_coordinates.size());
      if (!vertex || !coordinate)
        return Error{ErrorCode::kMalformed, model_.get().faceName(model_.get().faceCount()) + " has the corner '" +
                                                std::string(word.substr(0, 40)) +
                                                "', which names nothing; correct or export the model again"};
      model_.addCorner({*vertex, *coordinate});
    }
    return model_.endFace(material_);
  }

  Status useMaterial(std::string_view name) {
    const auto found = materials_.find(std::string(name));
    material_ = found == materials_.end() ? kNoIndex : found->second;
    return {};
  }
  Status readLibrary(const std::string& file) {
    const Result<Bytes> bytes = library_(file);
    if (!bytes.ok()) return {};
    const auto text = std::string_view(reinterpret_cast<const char*>(bytes->data()), bytes->size());
    for (Material& material : parseLibrary(text)) {
      auto& all = model_.edit().materials;
      if (all.size() == kMaxModelMaterials) return Error{ErrorCode::kLimit, file + ": more than 65536 materials"};
      materials_[material.name] = static_cast<uint32_t>(all.size());
      all.push_back(std::move(material));
    }
    return {};
  }

  CheckedModel model_;
  const FileReader& library_;
  std::map<std::string, uint32_t> materials_;
  uint32_t material_ = kNoIndex;
};

}  // namespace

Result<Model> parseObj(std::string_view text, const std::string& name, const FileReader& library) {
  return ObjParser(name, library).parse(text);
}

}  // namespace foreland::terrain
