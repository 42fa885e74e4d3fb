#include "proto/message/tile_message.h"

#include <cmath>

#include "proto/message/kind.h"

namespace foreland::proto {

namespace {

constexpr uint8_t kStatement = 0xff;  // no level is so high

bool isSane(const TileBounds& b) {
  return std::abs(b.lowest_m) <= 1e7f && std::abs(b.highest_m) <= 1e7f && b.lowest_m <= b.highest_m;
}

}  // namespace

Bytes encode(const TileMessage& m) {
  Bytes out;
  ByteWriter w(out);
  w.put(MessageKind::kTile);
  w.put(static_cast<uint8_t>(m.tile.layer << 5 | m.tile.level));
  w.putVarint(m.tile.x);
  w.putVarint(m.tile.y);
  w.put(m.bounds.lowest_m);
  w.put(m.bounds.highest_m);
  for (const int8_t each : m.bounds.axis) w.put(each);
  w.put(m.bounds.half_angle);
  w.putBytes(m.coded);
  return out;
}

Bytes encode(const TileStatement& m) {
  Bytes out;
  ByteWriter w(out);
  w.put(MessageKind::kTile);
  w.put(kStatement);
  w.putVarint(m.keyframe);
  for (const float each : m.texel_px) w.put(each);
  return out;
}

bool isTileStatement(ByteSpan bytes) { return bytes.size() > 1 && bytes[1] == kStatement; }

Result<TileMessage> decodeTile(ByteSpan bytes) {
  ByteReader r(bytes.subspan(1));
  TileMessage m;
  const uint8_t place = r.get<uint8_t>();
  const uint64_t x = r.getVarint(), y = r.getVarint();
  m.bounds.lowest_m = r.get<float>();
  m.bounds.highest_m = r.get<float>();
  for (int8_t& each : m.bounds.axis) each = r.get<int8_t>();
  m.bounds.half_angle = r.get<uint8_t>();
  if (!r.ok() || x >> 24 != 0 || y >> 24 != 0 || !isSane(m.bounds) || r.remaining() > kMaxTileBytes)
    return malformed("a tile's header is damaged");
  m.tile = {static_cast<uint8_t>(place >> 5), static_cast<uint8_t>(place & 31), static_cast<uint32_t>(x),
            static_cast<uint32_t>(y)};
  if (m.tile.layer >= kMaxTileLayers || m.tile.level >= kMaxTileLevels)
    return malformed("a tile is of no layer or level");
  const ByteSpan coded = r.getBytes(r.remaining());
  m.coded.assign(coded.begin(), coded.end());
  return m;
}

Result<TileStatement> decodeTileStatement(ByteSpan bytes) {
  ByteReader r(bytes.subspan(2));
  TileStatement m;
  const uint64_t keyframe = r.getVarint();
  for (float& each : m.texel_px) {
    each = r.get<float>();
    if (!(each >= 0)) return malformed("a size of texels is no number");
  }
  if (!r.atEnd() || keyframe > 0xffffffffu) return malformed("a statement about tiles is damaged");
  m.keyframe = static_cast<uint32_t>(keyframe);
  return m;
}

}  // namespace foreland::proto
