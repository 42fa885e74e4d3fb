#include "terrain/store/format.h"

#include <algorithm>
namespace foreland::terrain {

namespace {

void putString(ByteWriter& out, const std::string& text) {
  out.put(static_cast<uint32_t>(text.size()));
  out.putBytes({reinterpret_cast<const uint8_t*>(text.data()), text.size()});
}

std::string getString(ByteReader& in) {
  const ByteSpan bytes = in.getBytes(in.get<uint32_t>());
  return {bytes.begin(), bytes.end()};
}

}  // namespace

FileLayout FileLayout::of(const proto::GridShape& shape, const proto::PageDirectory& directory, const Sizes& sizes) {
  FileLayout layout;
  const std::array<uint64_t, kChecksums + 4> bytes{
      sizes.text,
      sizeof(int32_t) * (shape.roots_x + 1ull) * (shape.roots_y + 1ull),
      sizeof(int32_t) * static_cast<uint64_t>(shape.roots_x) * shape.roots_y,
      sizes.coded_pages > 0 ? sizes.coded_pages : sizeof(NodeRecord) * proto::kPageSlots * directory.pageCount(),
      sizes.objects,
      sizes.epochs,
      sizes.tiles,
      sizes.datum,
      directory.blocks().size_bytes()};
  std::array<SectionRange, kSectionCount + 4> ranges;
  layout.file_bytes = layOutSections(bytes, ranges);
  std::copy_n(ranges.begin(), kChecksums, layout.sections.begin());
  layout.sections[kChecksums] = ranges.back();
  if (sizes.epochs > 0) layout.epochs = ranges[kChecksums];
  if (sizes.tiles > 0) layout.tiles = ranges[kChecksums + 1];
  if (sizes.datum > 0) layout.datum = ranges[kChecksums + 2];
  if (!directory.blocks().empty()) layout.pages = ranges[kChecksums + 3];
  return layout;
}

void putFrame(const proto::Frame& f, FileHeader& h) {
  h.frame_kind = static_cast<uint32_t>(f.kind);
  h.height_quantum_m = f.height_quantum_m;
  const auto putPair = [](double(&to)[2], const glm::dvec2& from) { to[0] = from.x, to[1] = from.y; };
  putPair(h.anchor, f.anchor);
  putPair(h.axis_x_m, f.axis_x_m);
  putPair(h.axis_y_m, f.axis_y_m);
  putPair(h.map_origin_m, f.map_origin_m);
  h.latitude0_rad = f.latitude0_rad;
  h.longitude0_rad = f.longitude0_rad;
  h.latitude_step_rad = f.latitude_step_rad;
  h.longitude_step_rad = f.longitude_step_rad;
  h.semi_major_m = f.semi_major_m;
  h.flattening = f.flattening;
  h.origin_latitude_rad = f.origin.latitude_rad;
  h.origin_longitude_rad = f.origin.longitude_rad;
  h.origin_height_m = f.origin.height_m;
}

proto::Frame getFrame(const FileHeader& h) {
  const auto pair = [](const double(&from)[2]) { return glm::dvec2(from[0], from[1]); };
  proto::Frame f;
  f.kind =
      static_cast<proto::FrameKind>(std::min(h.frame_kind, 255u));  // an unknown kind is refused by Frame::validate
  if (f.kind == proto::FrameKind::kGlobe && h.root_log2 < 32) f.face_steps = 1u << h.root_log2;
  f.height_quantum_m = h.height_quantum_m;
  f.anchor = pair(h.anchor);
  f.axis_x_m = pair(h.axis_x_m);
  f.axis_y_m = pair(h.axis_y_m);
  f.map_origin_m = pair(h.map_origin_m);
  f.latitude0_rad = h.latitude0_rad;
  f.longitude0_rad = h.longitude0_rad;
  f.latitude_step_rad = h.latitude_step_rad;
  f.longitude_step_rad = h.longitude_step_rad;
  f.semi_major_m = h.semi_major_m;
  f.flattening = h.flattening;
  f.origin = {h.origin_latitude_rad, h.origin_longitude_rad, h.origin_height_m};
  return f;
}

Bytes encodeText(const SceneOrigin& origin) {
  Bytes bytes;
  ByteWriter out(bytes);
  putString(out, origin.title);
  putString(out, origin.crs_wkt);
  out.put(static_cast<uint32_t>(origin.notes.size()));
  for (const std::string& note : origin.notes) putString(out, note);
  return bytes;
}

Status decodeText(ByteSpan bytes, SceneOrigin& origin) {
  ByteReader in(bytes);
  origin.title = getString(in);
  origin.crs_wkt = getString(in);
  const uint32_t count = in.get<uint32_t>();
  for (uint32_t i = 0; i < count && in.ok(); ++i) origin.notes.push_back(getString(in));
  if (!in.atEnd()) return Error{ErrorCode::kMalformed, "its text is damaged"};
  return {};
}

}  // namespace foreland::terrain
