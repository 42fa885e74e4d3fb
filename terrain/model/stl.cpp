#include <algorithm>
#include <bit>
#include <iterator>
#include <string>

#include "base/lines.h"
#include "base/utf8.h"
#include "terrain/model/checked_model.h"
#include "terrain/model/read_model.h"
#include "terrain/model/unique_positions.h"
#include "terrain/model/words.h"

namespace foreland::terrain {

namespace {

constexpr size_t kHeaderBytes = 84;    // 80 of any text, and the number of triangles
constexpr size_t kTriangleBytes = 50;  // normal, three positions, two bytes of any use

uint32_t triangleCount(ByteSpan bytes) {
  uint32_t count = 0;
  for (size_t i = 0; i < 4; ++i) count |= uint32_t{bytes[80 + i]} << (8 * i);
  return count;
}

float floatAt(ByteSpan bytes, size_t at) {
  uint32_t bits = 0;
  for (size_t i = 0; i < 4; ++i) bits |= uint32_t{bytes[at + i]} << (8 * i);
  return std::bit_cast<float>(bits);
}

// Whether the triangles that a binary header promises are all there. In text those four bytes are characters, which
// promise more than any file holds.
bool isCompleteBinary(ByteSpan bytes) {
  return bytes.size() >= kHeaderBytes && kHeaderBytes + uint64_t{kTriangleBytes} * triangleCount(bytes) <= bytes.size();
}

// Binary files may begin with "solid", too, and end with padding; text may begin with blanks and have no name. So the
// number of triangles decides first, then the words; what begins as text but holds zeros is binary and cut short, if
// they are no padding at its end. `is_own`: the text was not converted from another encoding.
bool isText(ByteSpan bytes, std::string_view utf8, bool is_own) {
  constexpr size_t kJudged = 1024;
  if (is_own && isCompleteBinary(bytes)) return false;
  Words words(utf8.substr(std::min(utf8.find_first_not_of(" \t\r\n"), utf8.size()), kJudged));
  const std::string first = lowered(words.next().substr(0, 5));
  return (first == "solid" || first == "facet") && utf8.substr(0, kJudged).find('\0') == std::string_view::npos;
}

class StlParser {
 public:
  explicit StlParser(const std::string& name) : model_(name, 1), vertices_(model_) {}

  Result<Model> parseBinary(ByteSpan bytes) {
    if (bytes.size() < kHeaderBytes) return fail({}, "is no STL file; export the model again");
    has_own_colours_ =
        std::string_view(reinterpret_cast<const char*>(bytes.data()), 80).find("COLOR=") != std::string_view::npos;
    if (has_own_colours_) readBodyColour(bytes);
    const uint64_t present = (bytes.size() - kHeaderBytes) / kTriangleBytes;
    uint64_t count = triangleCount(bytes);
    // Programs that write triangles before they know how many there will be leave 0 or -1 there.
    if ((count == 0 || count == 0xffffffff) && present > 0 && bytes.size() == kHeaderBytes + kTriangleBytes * present) {
      model_.edit().notes.push_back("gives no number of triangles; all " + std::to_string(present) + " are read");
      count = present;
    }
    if (count > present)
      return fail({}, "promises " + std::to_string(count) + " triangles, but ends after " + std::to_string(present) +
                          "; copy or export it again");
    for (uint64_t t = 0; t < count; ++t)
      if (Status status = parseTriangle(bytes.subspan(kHeaderBytes + kTriangleBytes * t, kTriangleBytes)); !status.ok())
        return fail({}, status.error().message);
    if (!is_coloured_) model_.edit().face_colours.clear();
    if (!is_coloured_) model_.leaveOut("attributes of triangles that are no colours", attributes_);
    const ByteSpan rest = bytes.subspan(kHeaderBytes + kTriangleBytes * count);
    if (std::any_of(rest.begin(), rest.end(), [](uint8_t byte) { return byte != 0; }))
      model_.leaveOut("bytes behind the last triangle", rest.size());
    return model_.finish();
  }

  Result<Model> parseText(std::string_view text) {
    Lines lines(text);
    for (std::string_view line; lines.next(line);)
      if (Status status = parseLine(line); !status.ok())
        return fail(":" + std::to_string(lines.number()), status.error().message);
    if (corners_ > 0) return fail({}, "ends within a facet; copy or export it again");
    return model_.finish();
  }

 private:
  Error fail(const std::string& line, const std::string& what) const {
    return {ErrorCode::kMalformed, model_.get().name + line + ": " + what};
  }
  Status parseTriangle(ByteSpan bytes) {
    for (size_t corner = 0; corner < 3; ++corner) {
      const size_t at = 12 + 12 * corner;
      if (Status status = addCorner({floatAt(bytes, at), floatAt(bytes, at + 4), floatAt(bytes, at + 8)}); !status.ok())
        return status;
    }
    addColour(bytes[48] | uint32_t{bytes[49]} << 8);
    return endFace();
  }
  // Materialise Magics has the body's colour in the header and marks triangles that have that colour; VisCAM and
  // SolidView mark those with a colour of their own, and have red and blue the other way round.
  void readBodyColour(ByteSpan bytes) {
    const std::string_view header(reinterpret_cast<const char*>(bytes.data()), 80);
    const size_t at = header.find("COLOR=") + 6;
    if (at + 4 > header.size()) return;
    for (size_t k = 0; k < 3; ++k) body_[k] = bytes[at + k];
    is_coloured_ = true;
  }
  void addColour(uint32_t attribute) {
    const bool is_marked = (attribute & 0x8000) != 0, is_own = is_marked != has_own_colours_;
    const auto channel = [&](uint32_t shift) { return static_cast<uint8_t>((attribute >> shift & 31) * 255 / 31); };
    const Colour low_red{channel(0), channel(5), channel(10), 255}, low_blue{channel(10), channel(5), channel(0), 255};
    if (attribute != 0) ++attributes_;
    is_coloured_ |= is_own && is_marked;
    model_.edit().face_colours.push_back(!is_own ? body_ : has_own_colours_ ? low_red : low_blue);
  }
  // Words of lines that say nothing that the corners do not.
  static bool isSilent(std::string_view key) {
    static constexpr std::string_view kKeys[] = {"", "solid", "facet", "outer", "endfacet", "endsolid", "end", "color"};
    return key.starts_with('#') || std::find(std::begin(kKeys), std::end(kKeys), key) != std::end(kKeys);
  }
  Status parseLine(std::string_view line) {
    Words words(line);
    const std::string key = lowered(words.next());
    if (key == "endloop" || (key == "end" && lowered(words.next()) == "loop")) return endFace();
    if (key != "vertex") {
      if (!isSilent(key)) model_.leaveOut("lines that are of no kind of STL");
      return {};
    }
    glm::dvec3 position;
    for (int axis = 0; axis < 3; ++axis) {
      const std::string_view word = words.next();
      const auto value = parseNumber<double>(word);
      if (!value)
        return Error{ErrorCode::kMalformed, "has '" + std::string(word.substr(0, 40)) +
                                                "' where a number belongs; correct or export it again"};
      position[axis] = *value;
    }
    return addCorner(position);
  }
  Status addCorner(const glm::dvec3& position) {
    const auto vertex = vertices_.vertexAt(position);
    if (!vertex.ok()) return vertex.error();
    model_.addCorner({*vertex, kNoIndex});
    ++corners_;
    return {};
  }
  Status endFace() {
    corners_ = 0;
    return model_.endFace(kNoIndex);
  }

  CheckedModel model_;
  UniquePositions vertices_;
  uint64_t corners_ = 0;  // of the face that has begun
  bool has_own_colours_ = false, is_coloured_ = false;
  Colour body_{255, 255, 255, 255};
  uint64_t attributes_ = 0;  // that are not 0
};

}  // namespace

Result<Model> parseStl(ByteSpan bytes, const std::string& name) {
  std::string storage;
  auto text = asUtf8({reinterpret_cast<const char*>(bytes.data()), bytes.size()}, storage);
  constexpr std::string_view kPadding("\0\x1a \t\r\n", 6);  // also what ended text in DOS
  if (text.ok()) text = text->substr(0, text->find_last_not_of(kPadding) + 1);
  if (!text.ok() || !isText(bytes, *text, storage.empty())) return StlParser(name).parseBinary(bytes);
  return StlParser(name).parseText(*text);
}

}  // namespace foreland::terrain
