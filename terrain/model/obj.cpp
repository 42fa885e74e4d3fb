#include <algorithm>
#include <cmath>
#include <map>
#include <set>

#include "base/lines.h"
#include "base/utf8.h"
#include "terrain/model/checked_model.h"
#include "terrain/model/read_model.h"
#include "terrain/model/share_colours.h"
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

constexpr const char* kOtherMaps = "maps of materials (bump, gloss, opacity and their like)";
constexpr const char* kOpacities = "opacities of materials (d, Tr)";
constexpr const char* kMapOptions = "options of textures (map_Kd -s, -o and their like)";

// Materials of one library; lines that are not understood are passed over, as by every reader of these files. What
// would change the look is counted in `model`.
std::vector<Material> parseLibrary(std::string_view bytes, const std::string& file, CheckedModel& model) {
  std::vector<Material> materials;
  std::string storage;
  const auto text = asUtf8(bytes, storage);
  Lines lines(text.ok() ? *text : std::string_view());
  for (std::string_view line; lines.next(line) && materials.size() < kMaxModelMaterials;) {
    Words words(line);
    const std::string key = lowered(words.next());
    if (key == "newmtl")
      materials.push_back({.name = std::string(words.rest().substr(0, kMaxModelMaterials)), .library = file});
    if (materials.empty()) continue;
    if (key == "map_kd") {
      materials.back().texture = textureName(words);
      if (words.rest().starts_with('-')) model.leaveOut(kMapOptions);
    } else if (key.starts_with("map_") || key == "bump" || key == "norm" || key == "disp" || key == "decal" ||
               key == "refl") {
      model.leaveOut(kOtherMaps);
    }
    if (key == "d" || key == "tr") {
      const double opaque = key == "d" ? 1 : 0;
      if (parseNumber<double>(words.next()).value_or(opaque) != opaque) model.leaveOut(kOpacities);
    }
    if (key == "kd")
      for (int channel = 0; channel < 3; ++channel)
        if (const auto share = parseNumber<double>(words.next()); share && std::isfinite(*share))
          materials.back().colour[channel] = toByte(*share);
  }
  return materials;
}

// Words that begin a line of an OBJ file and say nothing of a polygonal surface or its colours.
bool isSilent(std::string_view key) {
  static constexpr std::string_view kKeys[] = {
      "",       "vn",     "g",    "o",    "s",     "mg",     "lod",  "bevel",      "c_interp", "d_interp",
      "usemap", "maplib", "call", "csh",  "ctech", "stech",  "parm", "trim",       "hole",     "scrv",
      "sp",     "con",    "deg",  "bmat", "step",  "cstype", "end",  "shadow_obj", "trace_obj"};
  return std::find(std::begin(kKeys), std::end(kKeys), key) != std::end(kKeys);
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
    finishColours();
    if (has_library_ || names_no_library_)
      model_.leaveOut("materials of faces that are in no material library", faces_without_material_);
    return model_.finish();
  }

 private:
  static constexpr size_t kMaxLibraries = 256;  // and names in a line

  Status parseLine(std::string_view line) {
    Words whole(line);
    const std::string_view first = whole.next();
    if (first == "usemtl") return useMaterial(whole.rest());
    if (first == "mtllib") return readLibraries(whole);
    if (first == "#MRGB") addPaint(whole.next());
    Words words(line.substr(0, line.find('#')));
    const std::string_view key = words.next();
    if (key == "v") return parseVertex(words);
    if (key == "vt") return parseTexture(words);
    if (key == "f") return parseFace(words);
    if (key == "l" || key == "p")
      model_.leaveOut("lines and points");
    else if (key == "curv" || key == "curv2" || key == "surf" || key == "vp")
      model_.leaveOut("parts of free-form curves and surfaces");
    else if (!isSilent(key))
      model_.leaveOut("lines that are of no kind of OBJ");
    return {};
  }

  static Error unreadable(const std::string& what, std::string_view word) {
    return {ErrorCode::kMalformed,
            what + " has '" + std::string(word.substr(0, 40)) + "' where a number belongs; correct or export it again"};
  }

  // ZBrush's colours of vertices, in their order: for each two hexadecimal digits of a mask, red, green and blue.
  void addPaint(std::string_view digits) {
    for (; digits.size() >= 8; digits.remove_prefix(8)) {
      Colour colour{255, 255, 255, 255};
      for (size_t channel = 0; channel < 3; ++channel) {
        const auto value = parseNumber<uint8_t>(digits.substr(2 + 2 * channel, 2), 16);
        if (!value) return model_.leaveOut("lines of #MRGB that are no colours");
        colour[channel] = *value;
      }
      if (paint_.size() < kMaxModelVertices) paint_.push_back(colour);
    }
    if (!digits.empty()) model_.leaveOut("lines of #MRGB that are no colours");
  }
  void finishColours() {
    Model& model = model_.edit();
    model.colours = colours_.finish(model.notes);
    if (!model.colours.empty()) return model_.leaveOut("colours of #MRGB, because vertices have others", paint_.size());
    if (paint_.size() > model.positions.size())
      model_.leaveOut("colours of #MRGB behind the last vertex", paint_.size() - model.positions.size());
    model.colours = std::move(paint_);
    if (!model.colours.empty()) model.colours.resize(model.positions.size(), Colour{255, 255, 255, 255});
  }

  // x y z, then perhaps w, or r g b, or both.
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
    if (const double* rgb = values + count - 3; count >= 6)
      colours_.add(model_.get().positions.size(), {rgb[0], rgb[1], rgb[2], 1});
    return model_.addPosition({values[0], values[1], values[2]});
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
    if (lacks_material_) ++faces_without_material_;
    return model_.endFace(material_);
  }

  Status useMaterial(std::string_view name) {
    auto found = materials_.end();
    for (const std::string_view possible : possibleNames(name))
      if (found == materials_.end()) found = materials_.find(std::string(possible));
    lacks_material_ = found == materials_.end() && !name.empty();
    material_ = found == materials_.end() ? kNoIndex : found->second;
    return {};
  }
  // One library, whose name may have blanks, or several.
  Status readLibraries(Words words) {
    names_no_library_ = false;
    const std::string whole(words.rest());
    if (libraries_.contains(whole) || missing_libraries_.contains(whole)) return {};
    if (libraries_.size() + missing_libraries_.size() >= kMaxLibraries) {
      model_.leaveOut("material libraries after the 256th");
      return {};
    }
    Result<Bytes> bytes = Bytes();
    Error missing;
    for (const std::string_view name : possibleNames(whole)) {
      const std::string file(name);
      if (bytes = library_(file); bytes.ok()) return addLibrary(file, *bytes);
      missing = bytes.error();
    }
    bool is_any = false;
    for (size_t i = 0; i < kMaxLibraries && whole.find_first_of(" \t") != std::string::npos && !words.atEnd(); ++i) {
      const std::string file(words.next());
      if (bytes = library_(file); !bytes.ok()) continue;
      is_any = true;
      if (Status status = addLibrary(file, *bytes); !status.ok()) return status;
    }
    if (is_any) return {};
    missing_libraries_.insert(whole);
    model_.edit().notes.push_back("without the colours of its material library: " + missing.message);
    return {};
  }
  Status addLibrary(const std::string& file, ByteSpan bytes) {
    has_library_ = true;
    if (!libraries_.insert(file).second) return {};
    const auto text = std::string_view(reinterpret_cast<const char*>(bytes.data()), bytes.size());
    for (Material& material : parseLibrary(text, file, model_)) {
      auto& all = model_.edit().materials;
      if (all.size() == kMaxModelMaterials) return Error{ErrorCode::kLimit, file + ": more than 65536 materials"};
      const auto index = static_cast<uint32_t>(all.size());
      materials_[material.name] = index;
      for (const std::string_view name : possibleNames(material.name)) materials_.try_emplace(std::string(name), index);
      all.push_back(std::move(material));
    }
    return {};
  }

  CheckedModel model_;
  const FileReader& library_;
  std::map<std::string, uint32_t> materials_;
  std::set<std::string> libraries_, missing_libraries_;
  bool has_library_ = false, names_no_library_ = true;
  uint32_t material_ = kNoIndex;
  bool lacks_material_ = false;
  uint64_t faces_without_material_ = 0;
  ShareColours colours_;       // of vertices
  std::vector<Colour> paint_;  // of vertices, too, as ZBrush writes them
};

}  // namespace

Result<Model> parseObj(std::string_view text, const std::string& name, const FileReader& library) {
  std::string storage;
  const auto utf8 = asUtf8(text, storage);
  if (!utf8.ok()) return Error{utf8.error().code, name + ": " + utf8.error().message};
  return ObjParser(name, library).parse(*utf8);
}

}  // namespace foreland::terrain
