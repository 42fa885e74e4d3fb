#include "terrain/dem/opened_inputs.h"

#include <algorithm>
#include <iterator>
#include <utility>

#include "terrain/dem/tiles.h"

namespace foreland::terrain {

namespace {

// Whether both say where they are, on maps that can be related.
bool isPlacedAlike(const Tile& a, const Tile& b) {
  return a.map.has_transform && b.map.has_transform && a.map.crs_wkt.empty() == b.map.crs_wkt.empty();
}

// The tiles that are not on the lattice of the first one. What has no position, or alone no reference system, cannot be
// laid over it, which the mosaic says.
std::vector<LaidTile> takeOthers(std::vector<Tile>& tiles) {
  std::vector<LaidTile> others;
  std::vector<Tile> alike;
  for (Tile& tile : tiles) {
    const bool is_alike = alike.empty() || !isPlacedAlike(alike.front(), tile) || isOnOneLattice(alike.front(), tile);
    if (is_alike)
      alike.push_back(std::move(tile));
    else
      others.push_back({std::move(tile), std::nullopt});
  }
  tiles = std::move(alike);
  return others;
}

// All tiles, those of insets last; `priorities` gets an entry for each of the latter.
Result<std::vector<Tile>> openAll(const std::vector<std::filesystem::path>& inputs, const OpenOptions& options,
                                  std::vector<int>& priorities, std::vector<std::string>& notes) {
  Result<std::vector<Tile>> tiles = openTiles(inputs, options, notes);
  if (!tiles.ok()) return tiles;
  OpenOptions inset_options = options;
  inset_options.keeps_map = true;
  inset_options.frame = FrameChoice::kAuto;
  inset_options.spacing_m.reset();
  for (const InsetFile& inset : options.insets) {
    Result<std::vector<Tile>> opened = openTiles({inset.file}, inset_options, notes);
    if (!opened.ok()) return opened;
    for (Tile& tile : *opened) {
      tiles->push_back(std::move(tile));
      priorities.push_back(inset.priority);
    }
  }
  return tiles;
}

}  // namespace

Result<OpenedInputs> openInputs(const std::vector<std::filesystem::path>& inputs, const OpenOptions& options) {
  if (inputs.empty()) return Error{ErrorCode::kInvalidArgument, "no elevation file was named"};
  OpenedInputs out;
  std::vector<int> priorities;
  Result<std::vector<Tile>> tiles = openAll(inputs, options, priorities, out.notes);
  if (!tiles.ok()) return tiles.error();
  auto datum = alignHeights(*tiles, options, out.notes);
  if (!datum.ok()) return datum.error();
  out.datum = std::move(*datum);
  std::vector<LaidTile> insets;
  const size_t plain = tiles->size() - priorities.size();
  for (size_t i = 0; i < priorities.size(); ++i) insets.push_back({std::move((*tiles)[plain + i]), priorities[i]});
  tiles->resize(plain);
  out.others = takeOthers(*tiles);
  std::ranges::move(insets, std::back_inserter(out.others));
  Result<Mosaic> mosaic = makeMosaic(std::move(tiles).value());
  if (!mosaic.ok()) return mosaic.error();
  out.base = std::move(*mosaic);
  return out;
}

}  // namespace foreland::terrain
