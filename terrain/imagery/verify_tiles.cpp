#include "terrain/imagery/verify_tiles.h"

#include "terrain/imagery/normal_cone.h"
#include "terrain/imagery/verify_globe_relief.h"
#include "terrain/imagery/verify_relief.h"
#include "terrain/imagery/webp.h"
#include "terrain/parallel.h"

namespace foreland::terrain {

void checkChildrensBounds(const TileTable& tiles, const proto::TileId& tile, uint64_t order, Faults& faults) {
  const auto own = tiles.bounds(tile);
  if (!own || tile.level == 0) return;
  for (uint32_t k = 0; k < 4; ++k) {
    const proto::TileId child = tile.child(k);
    if (!tiles.layers()[tile.layer].has(child)) continue;
    const auto bounds = tiles.bounds(child);
    if (!bounds) continue;
    if (bounds->lowest_m < own->lowest_m || bounds->highest_m > own->highest_m ||
        !NormalCone::of(*own).holds(NormalCone::of(*bounds)))
      faults.add(order, nameOf(tile) + " has bounds that do not hold those of a finer one");
  }
}

namespace {

LayerReport verifyImagery(const Scene& scene, uint8_t layer, unsigned threads, Faults& faults) {
  const TileTable& tiles = scene.tiles();
  std::vector<proto::TileId> ids;
  tiles.forEach(layer, [&](const proto::TileId& id) {
    if (tiles.bounds(id)) ids.push_back(id);
  });
  std::vector<std::vector<Rgb>> pixels(threadCount(threads),
                                       std::vector<Rgb>(size_t{proto::kTileSide} * proto::kTileSide));
  parallelFor(
      ids.size(), threads,
      [&](uint64_t i, unsigned worker) {
        if (!decodeTile(tiles.bytes(ids[i]), pixels[worker]).ok()) faults.add(i, nameOf(ids[i]) + " cannot be decoded");
        checkChildrensBounds(tiles, ids[i], i, faults);
      },
      [](uint64_t) { return true; });
  return {.content = proto::TileContent::kImagery, .tiles = ids.size()};
}

}  // namespace

TilesReport verifyTiles(const Scene& scene, unsigned threads) {
  TilesReport report;
  Faults faults;
  const TileTable& tiles = scene.tiles();
  tiles.check([&](const std::string& what) { faults.add(0, what); });
  for (size_t at = 0; at < tiles.layers().size(); ++at) {
    const auto i = static_cast<uint8_t>(at);
    const proto::TileLayer& layer = tiles.layers()[i];
    const bool is_relief = layer.content == proto::TileContent::kRelief;
    report.layers.push_back(!is_relief        ? verifyImagery(scene, i, threads, faults)
                            : layer.isGlobe() ? verifyGlobeRelief(scene, i, threads, faults)
                                              : verifyRelief(scene, i, threads, faults));
  }
  report.faults = faults.count();
  report.first_faults = faults.first();
  return report;
}

Result<TilesReport> verifyTiles(const std::filesystem::path& path, unsigned threads) {
  const auto scene = Scene::open(path);
  if (!scene.ok()) return scene.error();
  return verifyTiles(**scene, threads);
}

}  // namespace foreland::terrain
