#include <algorithm>
#include <cctype>
#include <cstring>

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

// Binary files may begin with "solid", too, so their size decides first.
bool isText(ByteSpan bytes) {
  const std::string_view text(reinterpret_cast<const char*>(bytes.data()), bytes.size());
  const bool is_exact =
      bytes.size() >= kHeaderBytes && bytes.size() == kHeaderBytes + uint64_t{kTriangleBytes} * triangleCount(bytes);
  return !is_exact && text.starts_with("solid");
}

class StlParser {
 public:
  explicit StlParser(const std::string& name) : model_(name, 1), vertices_(model_) {}

  Result<Model> parseBinary(ByteSpan bytes) {
    if (bytes.size() < kHeaderBytes) return fail({}, "is no STL file; export the model again");
    const uint64_t count = triangleCount(bytes), present = (bytes.size() - kHeaderBytes) / kTriangleBytes;
    if (count > present)
      return fail({}, "promises " + std::to_string(count) + " triangles, but ends after " + std::to_string(present) +
                          "; copy or export it again");
    for (uint64_t t = 0; t < count; ++t)
      if (Status status = parseTriangle(bytes.subspan(kHeaderBytes + kTriangleBytes * t, kTriangleBytes)); !status.ok())
        return fail({}, status.error().message);
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
    return endFace();
  }
  // Lines with other words say nothing that the corners do not.
  Status parseLine(std::string_view line) {
    Words words(line);
    std::string key(words.next());
    std::transform(key.begin(), key.end(), key.begin(), [](unsigned char c) { return std::tolower(c); });
    if (key == "endloop") return endFace();
    if (key != "vertex") return {};
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
};

}  // namespace

Result<Model> parseStl(ByteSpan bytes, const std::string& name) {
  if (!isText(bytes)) return StlParser(name).parseBinary(bytes);
  return StlParser(name).parseText({reinterpret_cast<const char*>(bytes.data()), bytes.size()});
}

}  // namespace foreland::terrain
