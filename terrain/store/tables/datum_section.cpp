#include "terrain/store/tables/datum_section.h"

#include <string_view>
#include <utility>

namespace foreland::terrain {

namespace {

void putText(ByteWriter& out, const std::string& text) {
  out.put(static_cast<uint32_t>(text.size()));
  out.putBytes({reinterpret_cast<const uint8_t*>(text.data()), text.size()});
}

std::string getText(ByteReader& in) {
  const ByteSpan bytes = in.getBytes(in.get<uint32_t>());
  return {bytes.begin(), bytes.end()};
}

void putUndulations(ByteWriter& out, const proto::UndulationGrid& grid) {
  out.put(grid.columns);
  out.put(grid.rows);
  for (const double value : {grid.first.x, grid.first.y, grid.step.x, grid.step.y, grid.max_error_m}) out.put(value);
  out.putBytes({reinterpret_cast<const uint8_t*>(grid.metres.data()), grid.metres.size() * sizeof(float)});
}

proto::UndulationGrid getUndulations(ByteReader& in) {
  proto::UndulationGrid grid;
  grid.columns = in.get<uint32_t>();
  grid.rows = in.get<uint32_t>();
  for (double* value : {&grid.first.x, &grid.first.y, &grid.step.x, &grid.step.y, &grid.max_error_m})
    *value = in.get<double>();
  const uint64_t count = uint64_t{grid.columns} * grid.rows;
  if (count > proto::UndulationGrid::kMaxValues || count * sizeof(float) > in.remaining())
    return grid;  // refused below
  grid.metres.resize(count);
  for (float& value : grid.metres) value = in.get<float>();
  return grid;
}

SceneInput getInput(ByteReader& in) {
  SceneInput input;
  input.name = getText(in);
  input.vertical = getText(in);
  for (uint32_t* value : {&input.window.x, &input.window.y, &input.window.width, &input.window.height})
    *value = in.get<uint32_t>();
  input.may_have_voids = in.get<uint32_t>() != 0;
  input.residual_m = in.get<double>();
  input.feather_m = in.get<double>();
  return input;
}

bool isInside(const proto::LatticeWindow& w, uint32_t samples_x, uint32_t samples_y) {
  return !w.isEmpty() && uint64_t{w.x} + w.width <= samples_x && uint64_t{w.y} + w.height <= samples_y;
}

Error damaged(const std::string& what) { return {ErrorCode::kMalformed, what}; }

// The text between quotes that follows `key`; empty if there is none.
std::string quotedAfter(const std::string& text, std::string_view key) {
  const size_t at = text.find(key);
  if (at == std::string::npos) return {};
  const size_t begin = at + key.size(), end = text.find('"', begin);
  return end == std::string::npos ? std::string() : text.substr(begin, end - begin);
}

}  // namespace

Bytes encodeDatum(const SceneDatum& datum) {
  Bytes bytes;
  ByteWriter out(bytes);
  out.put(static_cast<uint32_t>(datum.vertical.zero_surface));
  putText(out, datum.vertical.name);
  putText(out, datum.vertical.geoid);
  putUndulations(out, datum.vertical.undulations);
  out.put(static_cast<uint32_t>(datum.inputs.size()));
  for (const SceneInput& input : datum.inputs) {
    putText(out, input.name);
    putText(out, input.vertical);
    for (const uint32_t value : {input.window.x, input.window.y, input.window.width, input.window.height})
      out.put(value);
    out.put(uint32_t{input.may_have_voids});
    out.put(input.residual_m);
    out.put(input.feather_m);
  }
  return bytes;
}

Result<SceneDatum> decodeDatum(ByteSpan bytes, uint32_t samples_x, uint32_t samples_y) {
  ByteReader in(bytes);
  SceneDatum datum;
  const auto kind = in.get<uint32_t>();
  if (kind > static_cast<uint32_t>(proto::ZeroSurface::kGeoid))
    return damaged("its vertical datum is of an unknown kind");
  datum.vertical.zero_surface = static_cast<proto::ZeroSurface>(kind);
  datum.vertical.name = getText(in);
  datum.vertical.geoid = getText(in);
  datum.vertical.undulations = getUndulations(in);
  if (Status s = datum.vertical.validate(); !s.ok()) return s.error();
  const auto count = in.get<uint32_t>();
  for (uint32_t i = 0; i < count && in.ok(); ++i) datum.inputs.push_back(getInput(in));
  if (!in.atEnd()) return damaged("its vertical datum is damaged");
  for (const SceneInput& input : datum.inputs)
    if (!isInside(input.window, samples_x, samples_y)) return damaged("one of its inputs lies beyond it");
  return datum;
}

proto::VerticalDatum datumOfReferenceSystem(const std::string& wkt) {
  for (const char* key : {"VERTCRS[\"", "VERT_CS[\""})
    if (std::string name = quotedAfter(wkt, key); !name.empty())
      return {proto::ZeroSurface::kGeoid, std::move(name), {}, {}};
  if (wkt.find("CS[ellipsoidal,3]") != std::string::npos) return {proto::ZeroSurface::kEllipsoid, "ellipsoid", {}, {}};
  return {};
}

}  // namespace foreland::terrain
