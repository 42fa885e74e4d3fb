#include "terrain/dem/datum.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include "terrain/dem/vertical/fit_undulations.h"
#include "terrain/dem/vertical/map_places.h"
#include "terrain/dem/vertical/shifted_raster.h"

namespace foreland::terrain {

namespace {

constexpr double kLargestUndulation_m = 200;  // of the earth: 107 m

std::optional<std::string> choiceFor(const Tile& tile, const OpenOptions& options) {
  const auto own = options.vertical_of.find(tile.input);
  return own != options.vertical_of.end() ? std::optional(own->second) : options.vertical;
}

EarthBox boxOf(const Tile& tile) {
  const RasterInfo& info = tile.raster->info();
  const auto places = MapPlaces::of(tile.map, info.name);
  return places ? places->box(info.width, info.height) : EarthBox{};
}

HeightReference statedBy(const Tile& tile, HeightReferences& known) {
  const std::string& wkt = tile.map.heights_wkt;
  return wkt.empty() ? HeightReference{} : known.statedBy(wkt, boxOf(tile));
}

Result<HeightReference> referenceOf(const Tile& tile, const OpenOptions& options, HeightReferences& known) {
  const auto choice = choiceFor(tile, options);
  const std::string& name = tile.raster->info().name;
  if (choice && *choice != kAsTheFileSays) {
    auto chosen = known.chosen(*choice);
    if (!chosen) return Error{chosen.error().code, name + ": --vertical " + chosen.error().message};
    return chosen;
  }
  HeightReference stated = statedBy(tile, known);
  if (choice && !stated.isStated())
    return Error{ErrorCode::kInvalidArgument,
                 name +
                     ": --vertical file: its reference system does not say what its heights are above; say "
                     "ellipsoid, egm96, egm2008 or a grid's file"};
  return stated;
}

bool isAsked(const OpenOptions& options) {
  return options.vertical || options.scene_vertical || !options.vertical_of.empty();
}

// Whether two of the references are stated, and not the same.
bool differ(const std::vector<HeightReference>& references) {
  const auto first = std::ranges::find_if(references, &HeightReference::isStated);
  return std::any_of(first, references.end(),
                     [&](const HeightReference& r) { return r.isStated() && r.name != first->name; });
}

Result<HeightReference> sceneReference(const std::vector<HeightReference>& references, const OpenOptions& options,
                                       HeightReferences& known) {
  if (options.scene_vertical) {
    auto chosen = known.chosen(*options.scene_vertical);
    if (!chosen) return Error{chosen.error().code, "--scene-vertical " + chosen.error().message};
    return chosen;
  }
  const auto stated = std::ranges::find_if(references, &HeightReference::isStated);
  return stated == references.end() ? HeightReference{} : *stated;
}

Status bring(Tile& tile, const HeightReference& from, const HeightReference& to) {
  const std::string name = tile.raster->info().name;
  for (const HeightReference* each : {&from, &to})
    if (!each->why_unknown.empty())
      return Error{ErrorCode::kNotFound, name + ": heights cannot be brought from " + from.name + " to " + to.name +
                                             ": " + each->why_unknown};
  auto places = MapPlaces::of(tile.map, name);
  if (!places) return places.error();
  tile.raster = shiftedRaster(std::move(tile.raster), std::move(*places), from, to);
  return {};
}

std::string fileNameOf(const Tile& tile) { return std::filesystem::path(tile.raster->info().name).filename().string(); }

// Column and row of the mosaic at a lattice position.
glm::dvec2 sampleAt(const Mosaic& mosaic, const RasterPlacement& placement, glm::dvec2 lattice) {
  return {placement.is_column_reversed ? mosaic.width - 1.0 - lattice.x : lattice.x,
          placement.is_row_reversed ? mosaic.height - 1.0 - lattice.y : lattice.y};
}

// The geoid's lines on the lattice, where that follows meridians and parallels.
std::optional<LatticeLines> linesOn(const Mosaic& mosaic, const RasterPlacement& placement, const Geoid& geoid) {
  const auto& t = mosaic.map.transform;
  const auto lines = geoid.lines();
  if (!lines || mosaic.map.kind != MapKind::kGeographic || t[2] != 0 || t[4] != 0) return std::nullopt;
  const auto degrees = [&](double x, double y) {
    const glm::dvec2 s = sampleAt(mosaic, placement, {x, y});
    return glm::dvec2(t[0] + s.x * t[1], t[3] + s.y * t[5]) * (mosaic.map.unit * 180 / std::numbers::pi) +
           glm::dvec2(mosaic.map.prime_meridian_rad * 180 / std::numbers::pi, 0);
  };
  const glm::dvec2 first = degrees(0, 0), step = degrees(1, 1) - first;
  if (!(step.x > 0 && step.y > 0)) return std::nullopt;
  return LatticeLines{(lines->first_degrees - first) / step, lines->step_degrees / step};
}

}  // namespace

Result<std::optional<Datum>> alignHeights(std::vector<Tile>& tiles, const OpenOptions& options,
                                          std::vector<std::string>& notes) {
  HeightReferences known;
  std::vector<HeightReference> references;
  for (const Tile& tile : tiles) {
    auto reference = referenceOf(tile, options, known);
    if (!reference) return reference.error();
    references.push_back(std::move(*reference));
  }
  if (!isAsked(options) && !differ(references)) return std::optional<Datum>();
  auto scene = sceneReference(references, options, known);
  if (!scene) return scene.error();
  if (!scene->isStated()) return std::optional<Datum>();
  Datum datum{*scene, *scene};
  for (size_t i = 0; i < tiles.size(); ++i) {
    tiles[i].vertical = references[i].name;
    if (!datum.geoid.geoid && references[i].geoid) datum.geoid = references[i];
    if (!references[i].isStated()) {
      notes.push_back(fileNameOf(tiles[i]) + ": nothing says what its heights are above; taken as " + scene->name +
                      ", as the scene's are (FILE@vertical=... says otherwise)");
    } else if (references[i].name != scene->name) {
      notes.push_back(fileNameOf(tiles[i]) + ": its heights are above " + references[i].name +
                      ", and were brought to " + scene->name);
      if (Status s = bring(tiles[i], references[i], *scene); !s.ok()) return s.error();
    }
  }
  return std::optional(std::move(datum));
}

Result<proto::VerticalDatum> datumOver(const Mosaic& mosaic, const RasterPlacement& placement, const Datum& datum,
                                       std::vector<std::string>& notes) {
  proto::VerticalDatum out{datum.scene.zero_surface, datum.scene.name, {}, {}};
  if (!datum.geoid.geoid) {
    if (!datum.geoid.why_unknown.empty()) notes.push_back("undulations are not known: " + datum.geoid.why_unknown);
    return out;
  }
  const auto places = MapPlaces::of(mosaic.map, mosaic.tiles.front().raster->info().name);
  if (!places) {
    notes.push_back("undulations of " + datum.geoid.name + " are not known: " + places.error().message);
    return out;
  }
  std::vector<glm::dvec2> degrees;
  const auto at = [&](std::span<const glm::dvec2> lattice, std::span<double> undulations) {
    degrees.clear();
    for (const glm::dvec2& p : lattice) degrees.push_back(sampleAt(mosaic, placement, p));
    places->toDegrees(degrees);
    datum.geoid.geoid->undulations(degrees, undulations);
  };
  auto grid = fitUndulations(mosaic.width, mosaic.height, linesOn(mosaic, placement, *datum.geoid.geoid), at);
  if (!grid) {
    notes.push_back("undulations of " + datum.geoid.name + " are not known: its grid does not cover the scene");
    return out;
  }
  if (const auto far = std::ranges::find_if(grid->metres, [](float n) { return std::fabs(n) > kLargestUndulation_m; });
      far != grid->metres.end())
    return Error{
        ErrorCode::kInvalidArgument,
        fmt::format("--vertical {}: no grid of undulations: it has {:g} m here, and the earth's are within 110 m "
                    "either way",
                    datum.geoid.name, *far)};
  out.geoid = datum.geoid.name;
  out.undulations = std::move(*grid);
  return out;
}

}  // namespace foreland::terrain
