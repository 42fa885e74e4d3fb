#include "terrain/dem/mosaic/mosaic.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <regex>

#include "terrain/dem/formats/gdal_georeference.h"

namespace foreland::terrain {

namespace {

constexpr double kMaxDrift = 0.5;      // samples over a tile, from slightly different steps
constexpr double kWorthSaying = 0.01;  // samples off the lattice
constexpr int64_t kMaxSide = int64_t{1} << 20;
constexpr int64_t kMaxSamples = int64_t{1} << 32;

struct Offset {
  double column = 0, row = 0;
};

double determinant(const std::array<double, 6>& t) { return t[1] * t[5] - t[2] * t[4]; }

// The column and row of a map position, in samples of a raster with transform `t`.
Offset toSamples(const std::array<double, 6>& t, double x, double y) {
  const double dx = x - t[0], dy = y - t[3], det = determinant(t);
  return {(dx * t[5] - dy * t[2]) / det, (dy * t[1] - dx * t[4]) / det};
}

std::string stepName(const Georeference& map) {
  return fmt::format("{:g}", std::hypot(map.transform[1], map.transform[4]));
}

// A reference system as GDAL's programs take it: by its number, else as a file has it.
std::string argumentOf(const Tile& tile) {
  static const std::regex kNumber("ID\\[\"EPSG\",([0-9]+)\\]\\]\\s*$");
  std::smatch found;
  if (std::regex_search(tile.map.crs_wkt, found, kNumber)) return "EPSG:" + found[1].str();
  return fmt::format("\"$(gdalsrsinfo --single-line -o wkt {})\"", tile.raster->info().name);
}

// What to do about it, where one of them has no reference system.
std::string wayToOneSystem(const Tile& first, const Tile& tile) {
  const bool is_first_unnamed = first.map.crs_name.empty();
  if (!is_first_unnamed && !tile.map.crs_name.empty()) return {};
  return "; if it is that of both, say so with gdal_translate -a_srs " + argumentOf(is_first_unnamed ? tile : first);
}

Status checkCompatible(const Tile& first, const Tile& tile) {
  const std::string both = first.raster->info().name + " and " + tile.raster->info().name;
  if (!first.map.has_transform || !tile.map.has_transform)
    return Error{ErrorCode::kInvalidArgument,
                 both + ": a mosaic needs positions, and one of them has none; build one scene from each"};
  if (!isSameReferenceSystem(first.map, tile.map))
    return Error{ErrorCode::kInvalidArgument,
                 fmt::format("{}: different reference systems ({}; {}){}", both,
                             first.map.crs_name.empty() ? "none" : first.map.crs_name,
                             tile.map.crs_name.empty() ? "none" : tile.map.crs_name, wayToOneSystem(first, tile))};
  // Along the tile's sides, its own samples must not drift away from those of the first tile.
  const auto& t = tile.map.transform;
  const double w = tile.raster->info().width - 1.0, h = tile.raster->info().height - 1.0;
  const Offset o = toSamples(first.map.transform, t[0], t[3]);
  const Offset e = toSamples(first.map.transform, t[0] + w * t[1], t[3] + w * t[4]);
  const Offset s = toSamples(first.map.transform, t[0] + h * t[2], t[3] + h * t[5]);
  const double drift = std::max({std::fabs(e.column - o.column - w), std::fabs(e.row - o.row),
                                 std::fabs(s.row - o.row - h), std::fabs(s.column - o.column)});
  if (!(drift <= kMaxDrift))
    return Error{ErrorCode::kInvalidArgument, fmt::format("{}: different resolutions ({} and {} per sample)", both,
                                                          stepName(first.map), stepName(tile.map))};
  return {};
}

// Moves a map across the date line to the side on which the first one lies.
void unwrap(const Georeference& first, Georeference& map) {
  if (map.kind != MapKind::kGeographic) return;
  const double turn = 2 * std::numbers::pi / map.unit;
  map.transform[0] -= turn * std::round((map.transform[0] - first.transform[0]) / turn);
}

}  // namespace

bool isOnOneLattice(const Tile& first, const Tile& tile) { return checkCompatible(first, tile).ok(); }

bool touch(const Tile& a, const Tile& b) {
  Georeference map = b.map;
  unwrap(a.map, map);
  const Offset o = toSamples(a.map.transform, map.transform[0], map.transform[3]);
  const auto meet = [](double at, uint32_t own, uint32_t other) { return at < own + 0.5 && at + other > -0.5; };
  return meet(o.column, a.raster->info().width, b.raster->info().width) &&
         meet(o.row, a.raster->info().height, b.raster->info().height);
}

Result<Mosaic> makeMosaic(std::vector<Tile> tiles) {
  Mosaic out;
  out.tiles = std::move(tiles);
  const Tile& first = out.tiles.front();
  std::vector<std::pair<int64_t, int64_t>> at;
  int64_t left = 0, top = 0, right = 0, bottom = 0;
  for (Tile& tile : out.tiles) {
    Offset exact;
    if (&tile != &first) {
      unwrap(first.map, tile.map);
      if (Status s = checkCompatible(first, tile); !s.ok()) return s.error();
      exact = toSamples(first.map.transform, tile.map.transform[0], tile.map.transform[3]);
    }
    if (!(std::fabs(exact.column) < 1e9 && std::fabs(exact.row) < 1e9))
      return Error{ErrorCode::kLimit, first.raster->info().name + " and " + tile.raster->info().name +
                                          ": too far apart for one scene; build one from each"};
    const int64_t column = std::llround(exact.column), row = std::llround(exact.row);
    const double off = std::max(std::fabs(exact.column - static_cast<double>(column)),
                                std::fabs(exact.row - static_cast<double>(row)));
    if (off > kWorthSaying)
      out.notes.push_back(fmt::format("{} lies {:.2f} samples off the lattice of {} and was shifted onto it",
                                      tile.raster->info().name, off, first.raster->info().name));
    tile.off_lattice = off;
    at.emplace_back(column, row);
    left = std::min(left, column);
    top = std::min(top, row);
    right = std::max(right, column + tile.raster->info().width);
    bottom = std::max(bottom, row + tile.raster->info().height);
  }
  const int64_t w = right - left, h = bottom - top;
  if (w > kMaxSide || h > kMaxSide || w > kMaxSamples / h)
    return Error{
        ErrorCode::kLimit,
        fmt::format("{} and the other inputs: together {} x {} samples, more than a scene holds; leave out what lies "
                    "far away",
                    first.raster->info().name, w, h)};
  out.width = static_cast<uint32_t>(w);
  out.height = static_cast<uint32_t>(h);
  for (size_t i = 0; i < out.tiles.size(); ++i) {
    out.tiles[i].column = static_cast<uint32_t>(at[i].first - left);
    out.tiles[i].row = static_cast<uint32_t>(at[i].second - top);
  }
  out.map = first.map;
  auto& t = out.map.transform;
  t[0] += static_cast<double>(left) * t[1] + static_cast<double>(top) * t[2];
  t[3] += static_cast<double>(left) * t[4] + static_cast<double>(top) * t[5];
  return out;
}

}  // namespace foreland::terrain
