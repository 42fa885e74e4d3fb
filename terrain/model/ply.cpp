#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <limits>
#include <utility>

#include "terrain/model/checked_model.h"
#include "terrain/model/ply_header.h"
#include "terrain/model/read_model.h"
#include "terrain/model/words.h"

namespace foreland::terrain {

namespace {

// The data behind the header as a row of numbers, in whichever form. Past the end, or at a word that is no number,
// ok() turns false for good and values are 0.
class PlyNumbers {
 public:
  PlyNumbers(ByteSpan bytes, PlyForm form)
      : bytes_(bytes),
        text_(reinterpret_cast<const char*>(bytes.data()), bytes.size()),
        is_ascii_(form == PlyForm::kAscii),
        swaps_(form == PlyForm::kBigEndian) {}

  bool ok() const { return ok_; }
  // An element with this many numbers cannot take fewer bytes.
  uint64_t remainingBytes() const { return is_ascii_ ? text_.size() : bytes_.size(); }
  static uint64_t minBytes(PlyType type, PlyForm form) { return form == PlyForm::kAscii ? 2 : plyTypeBytes(type); }

  double next(PlyType type) { return is_ascii_ ? nextWord() : nextBinary(type); }

 private:
  double nextWord() {
    const size_t begin = std::min(text_.find_first_not_of(" \t\r\n"), text_.size());
    text_.remove_prefix(begin);
    const size_t end = std::min(text_.find_first_of(" \t\r\n"), text_.size());
    const auto value = parseNumber<double>(text_.substr(0, end));
    text_.remove_prefix(end);
    if (!value) ok_ = false;
    return value.value_or(0);
  }
  double nextBinary(PlyType type) {
    switch (type) {
      case PlyType::kInt8:
        return take<int8_t>();
      case PlyType::kUint8:
        return take<uint8_t>();
      case PlyType::kInt16:
        return take<int16_t>();
      case PlyType::kUint16:
        return take<uint16_t>();
      case PlyType::kInt32:
        return take<int32_t>();
      case PlyType::kUint32:
        return take<uint32_t>();
      case PlyType::kFloat:
        return take<float>();
      case PlyType::kDouble:
        return take<double>();
    }
    return 0;
  }
  template <class T>
  double take() {
    if (!ok_ || bytes_.size() < sizeof(T)) {
      ok_ = false;
      return 0;
    }
    std::array<uint8_t, sizeof(T)> raw;
    std::copy_n(bytes_.begin(), sizeof(T), raw.begin());
    if (swaps_) std::reverse(raw.begin(), raw.end());
    bytes_ = bytes_.subspan(sizeof(T));
    return static_cast<double>(std::bit_cast<T>(raw));
  }

  ByteSpan bytes_;
  std::string_view text_;
  bool is_ascii_, swaps_, ok_ = true;
};

// What a property of a vertex means to us.
enum class Meaning : uint8_t { kX, kY, kZ, kRed, kGreen, kBlue, kAlpha, kU, kV, kOther };

Meaning meaningOf(const std::string& name) {
  static constexpr std::pair<std::string_view, Meaning> kNames[] = {
      {"x", Meaning::kX},         {"y", Meaning::kY},         {"z", Meaning::kZ},         {"red", Meaning::kRed},
      {"green", Meaning::kGreen}, {"blue", Meaning::kBlue},   {"alpha", Meaning::kAlpha}, {"s", Meaning::kU},
      {"u", Meaning::kU},         {"texture_u", Meaning::kU}, {"t", Meaning::kV},         {"v", Meaning::kV},
      {"texture_v", Meaning::kV},
  };
  for (const auto& [known, meaning] : kNames)
    if (known == name) return meaning;
  return Meaning::kOther;
}

uint8_t toChannel(double value, PlyType type) {
  const double scaled = type >= PlyType::kFloat ? value * 255 : type == PlyType::kUint16 ? value / 257 : value;
  return static_cast<uint8_t>(std::lround(std::isfinite(scaled) ? std::clamp(scaled, 0.0, 255.0) : 0));
}

class PlyParser {
 public:
  PlyParser(const PlyHeader& header, ByteSpan data, const std::string& name)
      : header_(header), numbers_(data, header.form), model_(name, 0) {}

  Result<Model> parse() {
    const auto fail = [&](const Error& error) { return Error{error.code, model_.get().name + ": " + error.message}; };
    for (const PlyElement& element : header_.elements) {
      if (Status status = checkCount(element); !status.ok()) return fail(status.error());
      if (Status status = parseElement(element); !status.ok()) return fail(status.error());
    }
    if (!header_.texture.empty()) {
      model_.edit().materials.push_back({.name = header_.texture, .texture = header_.texture});
      std::fill(model_.edit().face_materials.begin(), model_.edit().face_materials.end(), 0);
    }
    return model_.finish();
  }

 private:
  // The elements that the header announces must fit into the remaining bytes.
  Status checkCount(const PlyElement& element) const {
    uint64_t least = 0;
    for (const PlyProperty& property : element.properties)
      least += PlyNumbers::minBytes(property.is_list ? property.count_type : property.type, header_.form);
    if (element.count > 0 && (least == 0 || element.count - 1 > numbers_.remainingBytes() / least))
      return Error{ErrorCode::kMalformed, "promises " + std::to_string(element.count) + " of '" + element.name +
                                              "', more than the file can hold; export or copy it again"};
    return {};
  }

  Status parseElement(const PlyElement& element) {
    const bool is_face = element.name == "face", is_vertex = element.name == "vertex";
    if (element.name == "tristrips")
      return Error{ErrorCode::kUnsupported, "has triangle strips; export it with faces instead"};
    if (is_vertex) {
      if (Status status = chooseMeanings(element); !status.ok()) return status;
    }
    for (uint64_t i = 0; i < element.count; ++i) {
      Status status;
      if (is_vertex)
        status = parseVertex(element);
      else
        status = parseLists(element, is_face);
      if (!numbers_.ok())
        return Error{ErrorCode::kMalformed,
                     element.name + ' ' + std::to_string(i) + " is cut short or no number; export or copy it again"};
      if (!status.ok()) return status;
    }
    return {};
  }

  Status chooseMeanings(const PlyElement& element) {
    uint32_t seen = 0;
    for (const PlyProperty& property : element.properties) {
      meanings_.push_back(property.is_list ? Meaning::kOther : meaningOf(property.name));
      seen |= 1u << static_cast<uint32_t>(meanings_.back());
    }
    const auto has = [&](Meaning a, Meaning b, Meaning c) {
      const uint32_t wanted =
          1u << static_cast<uint32_t>(a) | 1u << static_cast<uint32_t>(b) | 1u << static_cast<uint32_t>(c);
      return (seen & wanted) == wanted;
    };
    if (!has(Meaning::kX, Meaning::kY, Meaning::kZ))
      return Error{ErrorCode::kMalformed, "its vertices have no x, y and z; export it again"};
    has_colours_ = has(Meaning::kRed, Meaning::kGreen, Meaning::kBlue);
    has_texture_ = has(Meaning::kU, Meaning::kV, Meaning::kU);
    return {};
  }

  Status parseVertex(const PlyElement& element) {
    std::array<double, 10> values{};
    Colour colour{255, 255, 255, 255};
    for (size_t p = 0; p < element.properties.size(); ++p) {
      const PlyProperty& property = element.properties[p];
      if (property.is_list) {
        if (Status status = skipList(property); !status.ok()) return status;
        continue;
      }
      const double value = numbers_.next(property.type);
      const auto meaning = static_cast<size_t>(meanings_[p]);
      values[meaning] = value;
      if (meanings_[p] >= Meaning::kRed && meanings_[p] <= Meaning::kAlpha)
        colour[meaning - static_cast<size_t>(Meaning::kRed)] = toChannel(value, property.type);
    }
    const auto of = [&](Meaning meaning) { return values[static_cast<size_t>(meaning)]; };
    if (Status status = model_.addPosition({of(Meaning::kX), of(Meaning::kY), of(Meaning::kZ)}); !status.ok())
      return status;
    if (has_colours_) model_.edit().colours.push_back(colour);
    if (has_texture_) return model_.addTextureCoordinate({of(Meaning::kU), of(Meaning::kV)});
    return {};
  }

  Result<uint64_t> listLength(const PlyProperty& property) {
    const double count = numbers_.next(property.count_type);
    const uint64_t least = PlyNumbers::minBytes(property.type, header_.form);
    if (!(count >= 0) || count - 1 > static_cast<double>(numbers_.remainingBytes()) / static_cast<double>(least) ||
        count != std::floor(count))
      return Error{ErrorCode::kMalformed, "has a list '" + property.name + "' longer than the file; export it again"};
    return static_cast<uint64_t>(count);
  }
  Status skipList(const PlyProperty& property) {
    const auto count = listLength(property);
    if (!count.ok()) return count.error();
    for (uint64_t i = 0; i < *count && numbers_.ok(); ++i) numbers_.next(property.type);
    return {};
  }
  // A face, or an element of a kind that is skipped.
  Status parseLists(const PlyElement& element, bool is_face) {
    bool found = false;
    for (const PlyProperty& property : element.properties) {
      const bool is_corners = is_face && property.is_list &&
                              (property.name == "vertex_indices" || property.name == "vertex_index") && !found;
      Status status;
      if (is_corners)
        status = parseFace(property), found = true;
      else if (property.is_list)
        status = skipList(property);
      else
        numbers_.next(property.type);
      if (!status.ok()) return status;
    }
    if (is_face && !found) return Error{ErrorCode::kMalformed, "its faces have no vertex_indices; export it again"};
    return {};
  }
  Status parseFace(const PlyProperty& property) {
    const auto count = listLength(property);
    if (!count.ok()) return count.error();
    for (uint64_t i = 0; i < *count && numbers_.ok(); ++i) {
      const double index = numbers_.next(property.type);
      if (!(index >= 0) || index >= kNoIndex || index != std::floor(index))
        return Error{ErrorCode::kMalformed, model_.get().faceName(model_.get().faceCount()) +
                                                " names a vertex that is no number from 0; "
                                                "correct or export the model again"};
      const auto vertex = static_cast<uint32_t>(index);
      model_.addCorner({vertex, has_texture_ ? vertex : kNoIndex});
    }
    return numbers_.ok() ? model_.endFace(kNoIndex) : Status();
  }

  const PlyHeader& header_;
  PlyNumbers numbers_;
  CheckedModel model_;
  std::vector<Meaning> meanings_;
  bool has_colours_ = false, has_texture_ = false;
};

}  // namespace

Result<Model> parsePly(ByteSpan bytes, const std::string& name) {
  const auto header = parsePlyHeader({reinterpret_cast<const char*>(bytes.data()), bytes.size()});
  if (!header.ok()) return Error{header.error().code, name + ": " + header.error().message};
  return PlyParser(*header, bytes.subspan(header->bytes), name).parse();
}

}  // namespace foreland::terrain
