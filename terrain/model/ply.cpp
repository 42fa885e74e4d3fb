#include <algorithm>
#include <array>
#include <cmath>
#include <initializer_list>
#include <span>
#include <utility>

#include "base/utf8.h"
#include "terrain/model/checked_model.h"
#include "terrain/model/ply_header.h"
#include "terrain/model/ply_numbers.h"
#include "terrain/model/read_model.h"
#include "terrain/model/share_colours.h"
#include "terrain/model/triangle_strip.h"

namespace foreland::terrain {

namespace {

// What a property of a vertex or a face means to us.
enum class Meaning : uint8_t { kX, kY, kZ, kRed, kGreen, kBlue, kAlpha, kU, kV, kTexture, kSilent, kOther };
constexpr size_t kMeanings = static_cast<size_t>(Meaning::kOther) + 1;

Meaning meaningOf(const std::string& name) {
  static constexpr std::pair<std::string_view, Meaning> kNames[] = {
      {"x", Meaning::kX},
      {"y", Meaning::kY},
      {"z", Meaning::kZ},
      {"red", Meaning::kRed},
      {"green", Meaning::kGreen},
      {"blue", Meaning::kBlue},
      {"alpha", Meaning::kAlpha},
      {"r", Meaning::kRed},
      {"g", Meaning::kGreen},
      {"b", Meaning::kBlue},
      {"a", Meaning::kAlpha},
      {"diffuse_red", Meaning::kRed},
      {"diffuse_green", Meaning::kGreen},
      {"diffuse_blue", Meaning::kBlue},
      {"diffuse_alpha", Meaning::kAlpha},
      {"s", Meaning::kU},
      {"u", Meaning::kU},
      {"texture_u", Meaning::kU},
      {"texture_s", Meaning::kU},
      {"t", Meaning::kV},
      {"v", Meaning::kV},
      {"texture_v", Meaning::kV},
      {"texture_t", Meaning::kV},
      {"texnumber", Meaning::kTexture},
      {"nx", Meaning::kSilent},
      {"ny", Meaning::kSilent},
      {"nz", Meaning::kSilent},
  };
  for (const auto& [known, meaning] : kNames)
    if (known == name) return meaning;
  return Meaning::kOther;
}

// The properties of an element that are no lists.
struct Columns {
  std::vector<Meaning> meanings;  // of all properties; of lists kOther
  uint32_t seen = 0;
  bool has_colours = false, has_float_colours = false;

  bool has(std::initializer_list<Meaning> all) const {
    return std::all_of(all.begin(), all.end(), [&](Meaning m) { return (seen >> static_cast<uint32_t>(m) & 1) != 0; });
  }
};

Columns columnsOf(const PlyElement& element) {
  Columns columns;
  for (const PlyProperty& property : element.properties) {
    const Meaning meaning = property.is_list ? Meaning::kOther : meaningOf(property.name);
    columns.meanings.push_back(meaning);
    columns.seen |= 1u << static_cast<uint32_t>(meaning);
    if (meaning >= Meaning::kRed && meaning <= Meaning::kAlpha)
      columns.has_float_colours |= property.type >= PlyType::kFloat;
  }
  columns.has_colours = columns.has({Meaning::kRed, Meaning::kGreen, Meaning::kBlue});
  return columns;
}

// The numbers of one vertex or face, by meaning.
struct Row {
  std::array<double, kMeanings> values{};
  Colour colour{255, 255, 255, 255};
  std::array<double, 4> shares{1, 1, 1, 1};  // the same colour, if it is of real numbers

  double of(Meaning meaning) const { return values[static_cast<size_t>(meaning)]; }
};

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
    model_.leaveOut("bytes behind the last element", numbers_.remainingContent());
    Model& model = model_.edit();
    if (!vertex_shares_.isEmpty()) model.colours = vertex_shares_.finish(model.notes);
    if (!face_shares_.isEmpty()) model.face_colours = face_shares_.finish(model.notes);
    for (const std::string& texture : header_.textures)
      model.materials.push_back({.name = texture, .texture = texture});
    if (header_.textures.empty())
      model_.leaveOut("texture coordinates, because no 'comment TextureFile' names their image",
                      model.texture_coordinates.size());
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
    const bool is_strip = element.name == "tristrips", is_face = element.name == "face" || is_strip,
               is_vertex = element.name == "vertex";
    if (Status status = choose(element, is_face, is_vertex); !status.ok()) return status;
    for (uint64_t i = 0; i < element.count; ++i) {
      const Status status = is_vertex  ? parseVertex(element)
                            : is_strip ? parseStrips(element)
                            : is_face  ? parseFace(element)
                                       : skip(element);
      if (!numbers_.ok())
        return Error{ErrorCode::kMalformed,
                     element.name + ' ' + std::to_string(i) + " is cut short or no number; export or copy it again"};
      if (!status.ok()) return status;
    }
    return {};
  }

  // What the properties of an element mean; what is not taken is counted.
  Status choose(const PlyElement& element, bool is_face, bool is_vertex) {
    const std::string shown = element.name.substr(0, 40);
    if (!is_face && !is_vertex) {
      model_.leaveOut("elements '" + shown + "'", element.count);
      return {};
    }
    Columns& columns = is_face ? face_ : vertex_;
    columns = columnsOf(element);
    for (size_t p = 0; p < element.properties.size(); ++p) {
      const PlyProperty& property = element.properties[p];
      const bool is_list_of_ours = is_face && property.is_list && (isCorners(property) || property.name == "texcoord");
      const bool is_unused = columns.meanings[p] == Meaning::kOther && !is_list_of_ours;
      if (is_unused)
        model_.leaveOut("property '" + property.name.substr(0, 40) + "' of '" + shown + "'", element.count);
    }
    if (is_vertex && !columns.has({Meaning::kX, Meaning::kY, Meaning::kZ}))
      return Error{ErrorCode::kMalformed, "its vertices have no x, y and z; export it again"};
    if (is_vertex) has_texture_ = columns.has({Meaning::kU, Meaning::kV});
    if (is_face && std::none_of(element.properties.begin(), element.properties.end(), isCorners) && element.count > 0)
      return Error{ErrorCode::kMalformed, "its faces have no vertex_indices; export it again"};
    return {};
  }

  void readNumber(const PlyProperty& property, Meaning meaning, Row& row) {
    const double value = numbers_.next(property.type);
    row.values[static_cast<size_t>(meaning)] = value;
    if (meaning < Meaning::kRed || meaning > Meaning::kAlpha) return;
    const size_t channel = static_cast<size_t>(meaning) - static_cast<size_t>(Meaning::kRed);
    row.colour[channel] = toChannel(value, property.type);
    row.shares[channel] = property.type >= PlyType::kFloat ? value : row.colour[channel] / 255.0;
  }
  Status parseVertex(const PlyElement& element) {
    Row row;
    for (size_t p = 0; p < element.properties.size(); ++p) {
      const PlyProperty& property = element.properties[p];
      if (!property.is_list)
        readNumber(property, vertex_.meanings[p], row);
      else if (Status status = readList(property, nullptr); !status.ok())
        return status;
    }
    const size_t index = model_.get().positions.size();
    if (Status status = model_.addPosition({row.of(Meaning::kX), row.of(Meaning::kY), row.of(Meaning::kZ)});
        !status.ok())
      return status;
    if (vertex_.has_colours && vertex_.has_float_colours)
      vertex_shares_.add(index, row.shares);
    else if (vertex_.has_colours)
      model_.edit().colours.push_back(row.colour);
    if (has_texture_) return model_.addTextureCoordinate({row.of(Meaning::kU), row.of(Meaning::kV)});
    return {};
  }
  Status skip(const PlyElement& element) {
    for (const PlyProperty& property : element.properties)
      if (!property.is_list)
        numbers_.next(property.type);
      else if (Status status = readList(property, nullptr); !status.ok())
        return status;
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
  // Into `numbers`, or past it.
  Status readList(const PlyProperty& property, std::vector<double>* numbers) {
    const auto count = listLength(property);
    if (!count.ok()) return count.error();
    if (numbers) numbers->clear();
    for (uint64_t i = 0; i < *count && numbers_.ok(); ++i) {
      const double value = numbers_.next(property.type);
      if (numbers) numbers->push_back(value);
    }
    return {};
  }
  static bool isCorners(const PlyProperty& property) {
    return property.is_list && (property.name == "vertex_indices" || property.name == "vertex_index");
  }
  Status parseFace(const PlyElement& element) {
    const auto row = readFace(element);
    if (!row.ok()) return row.error();
    return numbers_.ok() ? addFace(*row, indices_) : Status();
  }
  Status parseStrips(const PlyElement& element) {
    const auto row = readFace(element);
    if (!row.ok()) return row.error();
    if (!numbers_.ok()) return {};
    return eachTriangleOfStrip(indices_, [&](std::span<const double> triangle) { return addFace(*row, triangle); });
  }
  // The numbers of a face, with its lists as `indices_` and `coordinates_`.
  Result<Row> readFace(const PlyElement& element) {
    Row row;
    indices_.clear();
    coordinates_.clear();
    bool has_corners = false;
    for (size_t p = 0; p < element.properties.size(); ++p) {
      const PlyProperty& property = element.properties[p];
      if (!property.is_list) {
        readNumber(property, face_.meanings[p], row);
        continue;
      }
      const bool is_corners = isCorners(property) && !std::exchange(has_corners, has_corners || isCorners(property));
      Status status = readList(property, is_corners                    ? &indices_
                                         : property.name == "texcoord" ? &coordinates_
                                                                       : nullptr);
      if (!status.ok()) return status.error();
    }
    return row;
  }
  Status addFace(const Row& row, std::span<const double> indices) {
    const bool has_own = coordinates_.size() == 2 * indices.size();
    if (!has_own && !coordinates_.empty()) model_.leaveOut("texture coordinates of faces that are not two a corner");
    for (size_t i = 0; i < indices.size(); ++i) {
      const double index = indices[i];
      if (!(index >= 0) || index >= kNoIndex || index != std::floor(index))
        return Error{ErrorCode::kMalformed, model_.get().faceName(model_.get().faceCount()) +
                                                " names a vertex that is no number from 0; "
                                                "correct or export the model again"};
      const auto vertex = static_cast<uint32_t>(index);
      uint32_t texture = has_texture_ ? vertex : kNoIndex;
      if (has_own) {
        texture = static_cast<uint32_t>(model_.get().texture_coordinates.size());
        Status status = model_.addTextureCoordinate({coordinates_[2 * i], coordinates_[2 * i + 1]});
        if (!status.ok()) return status;
      }
      model_.addCorner({vertex, texture});
    }
    const size_t face = model_.get().faceCount();
    if (Status status = model_.endFace(materialOf(row)); !status.ok()) return status;
    if (face_.has_colours && face_.has_float_colours)
      face_shares_.add(face, row.shares);
    else if (face_.has_colours)
      faceColour(face) = row.colour;
    return {};
  }
  Colour& faceColour(size_t face) {
    std::vector<Colour>& colours = model_.edit().face_colours;
    colours.resize(face + 1, Colour{255, 255, 255, 255});
    return colours[face];
  }
  // Which texture a face wears: the first if the file does not say.
  uint32_t materialOf(const Row& row) const {
    const double number = row.of(Meaning::kTexture);
    const bool is_one = number >= 0 && number < static_cast<double>(header_.textures.size());
    return is_one ? static_cast<uint32_t>(number) : kNoIndex;
  }

  const PlyHeader& header_;
  PlyNumbers numbers_;
  CheckedModel model_;
  Columns vertex_, face_;
  ShareColours vertex_shares_, face_shares_;
  std::vector<double> indices_, coordinates_;  // of the face that is read
  bool has_texture_ = false;                   // whether vertices have texture coordinates
};

}  // namespace

Result<Model> parsePly(ByteSpan bytes, const std::string& name) {
  std::string storage;
  const auto text = asUtf8({reinterpret_cast<const char*>(bytes.data()), bytes.size()}, storage);
  if (!text.ok()) return Error{text.error().code, name + ": " + text.error().message};
  const auto header = parsePlyHeader(*text);
  if (!header.ok()) return Error{header.error().code, name + ": " + header.error().message};
  const ByteSpan data(reinterpret_cast<const uint8_t*>(text->data()), text->size());
  return PlyParser(*header, data.subspan(header->bytes), name).parse();
}

}  // namespace foreland::terrain
