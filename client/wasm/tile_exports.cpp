// The module's exports about tiles of relief and imagery: which are drawn, and what is made of them.
#include "client/wasm/conversions.h"
#include "client/wasm/host.h"
#include "client/wasm/record_layout.h"

namespace foreland::client {
namespace {

std::array<uint32_t, 2> halvesOf(uint64_t key) {
  return {static_cast<uint32_t>(key), static_cast<uint32_t>(key >> 32)};
}
proto::TileId tileOf(uint32_t low, uint32_t high) { return proto::TileId::of(uint64_t{high} << 32 | low); }

void fillTiles(proto::TileContent content, const Residency& residency, Host& host) {
  TilesRecord& out = host.tiles_record;
  host.arrivals.clear(), host.dropped.clear();
  for (const Residency::Arrival& a : residency.arrivals()) {
    const auto [low, high] = halvesOf(a.tile.key());
    host.arrivals.insert(host.arrivals.end(), {low, high, a.texture_layer, a.parent_layer.value_or(kNoLayer), 0});
  }
  if (content == proto::TileContent::kRelief)
    for (const Residency::Shown& r : host.newest.drape()->relit()) {
      const auto [low, high] = halvesOf(r.tile.key());
      host.arrivals.insert(host.arrivals.end(), {low, high, r.texture_layer, kNoLayer, 1});
    }
  for (const proto::TileId& tile : residency.dropped()) {
    const auto [low, high] = halvesOf(tile.key());
    host.dropped.insert(host.dropped.end(), {low, high});
  }
  out.scene = host.newest.drapedScene();
  out.shown = static_cast<uint32_t>(residency.shown().size());
  out.page_table = addressOf(residency.pageTable().data());
  out.page_count = static_cast<uint32_t>(residency.pageTable().size() / 4);
  out.arrivals = addressOf(host.arrivals.data());
  out.arrival_count = static_cast<uint32_t>(host.arrivals.size() / 5);
  out.dropped = addressOf(host.dropped.data());
  out.dropped_count = static_cast<uint32_t>(residency.dropped().size());
}

}  // namespace

// How many layers the texture arrays of relief and imagery have. To be called before the first mesh is taken.
FORELAND_EXPORT(foreland_set_texture_layers)
void setTextureLayers(Host* host, uint32_t relief, uint32_t imagery) {
  host->newest.setTextureLayers({relief, imagery});
}

// What the host had taken is lost (its graphics card was reset): the newest mesh is taken again, and all tiles come
// again with it and those that follow.
FORELAND_EXPORT(foreland_redraw) void redraw(Host* host) { host->newest.redraw(); }

// What of the tiles of a proto::TileContent is drawn with the mesh that was taken last. Null if the scene has none.
FORELAND_EXPORT(foreland_tiles) const TilesRecord* tiles(Host* host, uint32_t content) {
  const Residency* residency = nullptr;
  if (host->newest.drape() && content < proto::kMaxTileLayers)
    residency = host->newest.drape()->residency(static_cast<proto::TileContent>(content));
  if (residency == nullptr) return nullptr;
  fillTiles(static_cast<proto::TileContent>(content), *residency, *host);
  return &host->tiles_record;
}

// Slopes of a tile of relief that arrives (`half` 0), and of its half-size image (`half` 1).
FORELAND_EXPORT(foreland_slopes) const uint32_t* slopes(Host* host, uint32_t low, uint32_t high, uint32_t half) {
  const proto::TileId tile = tileOf(low, high);
  return half == 0 ? host->newest.drape()->slopes(tile).data() : host->newest.drape()->halfSlopes(tile).data();
}

// Its ground texels likewise (client/imagery/shadows.h), also of tiles that are relit.
FORELAND_EXPORT(foreland_ground_texels)
const uint32_t* groundTexels(Host* host, uint32_t low, uint32_t high, uint32_t half) {
  const proto::TileId tile = tileOf(low, high);
  return half == 0 ? host->newest.drape()->ground(tile).data() : host->newest.drape()->halfGround(tile).data();
}

// Towards the sun, in the scene's axes, if it casts shadows (`wanted` 1).
FORELAND_EXPORT(foreland_set_sun) void setSun(Host* host, double x, double y, double z, uint32_t wanted) {
  host->newest.setSun(wanted == 1 ? std::optional(glm::dvec3{x, y, z}) : std::nullopt);
}

// Decodes a tile of relief, if one is wanted: 1 if so.
FORELAND_EXPORT(foreland_decode_relief) uint32_t decodeRelief(Host* host) {
  return host->newest.drape() && host->newest.drape()->decodeRelief() ? 1 : 0;
}

// The next image to be decoded, each once; null if there is none.
FORELAND_EXPORT(foreland_next_image) const ImageRecord* nextImage(Host* host) {
  if (!host->newest.drape()) return nullptr;
  const auto tile = host->newest.drape()->takeWantedImage();
  const HeldTile* held = tile ? host->viewer.tiles().find(*tile) : nullptr;
  if (held == nullptr) return nullptr;
  const auto [low, high] = halvesOf(tile->key());
  host->image_record = {{low, high}, addressOf(held->coded.data()), static_cast<uint32_t>(held->coded.size())};
  return &host->image_record;
}

// The image of a tile has been decoded.
FORELAND_EXPORT(foreland_image_ready) void imageReady(Host* host, uint32_t low, uint32_t high) {
  if (host->newest.drape()) host->newest.drape()->setImageReady(tileOf(low, high));
}

}  // namespace foreland::client
