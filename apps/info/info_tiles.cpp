#include "apps/info/info_tiles.h"

#include <cinttypes>
#include <cstdio>
#include <vector>

namespace foreland::apps {

namespace {

using nlohmann::ordered_json;

struct LevelCost {
  uint64_t tiles = 0, stored = 0, bytes = 0;
};

std::vector<LevelCost> costOf(const terrain::TileTable& tiles, uint8_t layer) {
  std::vector<LevelCost> levels(tiles.layers()[layer].levels());
  tiles.forEach(layer, [&](const proto::TileId& id) {
    LevelCost& level = levels[id.level];
    const size_t bytes = tiles.bytes(id).size();
    ++level.tiles, level.stored += bytes > 0 ? 1 : 0, level.bytes += bytes;
  });
  return levels;
}

LevelCost sumOf(const std::vector<LevelCost>& levels) {
  LevelCost sum;
  for (const LevelCost& l : levels) sum.tiles += l.tiles, sum.stored += l.stored, sum.bytes += l.bytes;
  return sum;
}

const char* nameOf(proto::TileContent content) { return content == proto::TileContent::kRelief ? "relief" : "imagery"; }
double megabytes(uint64_t bytes) { return static_cast<double>(bytes) * 1e-6; }

}  // namespace

ordered_json describeTiles(const terrain::TileTable& tiles) {
  ordered_json layers = ordered_json::array();
  for (size_t i = 0; i < tiles.layers().size(); ++i) {
    const proto::TileLayer& l = tiles.layers()[i];
    const auto levels = costOf(tiles, static_cast<uint8_t>(i));
    const LevelCost sum = sumOf(levels);
    ordered_json layer{
        {"content", nameOf(l.content)},  {"coding", l.coding == proto::TileCoding::kHeights ? "heights" : "webp"},
        {"texels", {l.width, l.height}}, {"texel_samples", l.texel},
        {"tiles", sum.stored},           {"megabytes", megabytes(sum.bytes)}};
    if (l.content == proto::TileContent::kRelief) layer["step_m"] = l.step_m;
    if (!l.attribution.empty()) layer["attribution"] = l.attribution;
    ordered_json by_level = ordered_json::array();
    for (const LevelCost& level : levels)
      by_level.push_back({{"tiles", level.tiles}, {"stored", level.stored}, {"megabytes", megabytes(level.bytes)}});
    layer["levels"] = std::move(by_level);
    layers.push_back(std::move(layer));
  }
  return layers;
}

void printTiles(const terrain::Scene& scene) {
  const terrain::TileTable& tiles = scene.tiles();
  for (size_t i = 0; i < tiles.layers().size(); ++i) {
    const proto::TileLayer& l = tiles.layers()[i];
    const LevelCost sum = sumOf(costOf(tiles, static_cast<uint8_t>(i)));
    const double texels = static_cast<double>(l.width) * l.height;
    std::printf("%-10s %u x %u texels, %u levels, %" PRIu64 " tiles, %.3f MB, %.2f bits a texel", nameOf(l.content),
                l.width, l.height, l.levels(), sum.stored, megabytes(sum.bytes),
                8 * static_cast<double>(sum.bytes) / texels);
    if (l.content == proto::TileContent::kRelief)
      std::printf(", heights in steps of %g m\n", l.step_m);
    else
      std::printf(", %" PRIu64 " more tiles show what coarser ones show\n", sum.tiles - sum.stored);
    if (!l.attribution.empty()) std::printf("  by       %s\n", l.attribution.c_str());
  }
  if (tiles.layers().empty())
    std::printf("relief     none%s\n", scene.epochs().epochs().empty() ? "; build the scene again to have it"
                                                                       : ": the ground changes in time");
}

}  // namespace foreland::apps
