#include "terrain/geoid/geoid.h"

#include <fmt/format.h>

#include <array>
#include <cmath>
#include <filesystem>
#include <limits>
#include <numbers>
#include <vector>

#include "terrain/geoid/proj_context.h"

namespace foreland::terrain {

struct Geoid::Parts {
  ProjContext context;
  ProjObject to_ellipsoid;  // longitude and latitude in degrees, height above the geoid to height above the ellipsoid
  std::string name;
  std::string grid;  // PROJ's name of it; empty if it is not one grid
};

namespace {

// A geoid that has a name of its own, with the names that PROJ knows its grid by: the newer one first.
struct NamedGeoid {
  const char *choice, *name, *vertical_crs;
  std::array<const char*, 2> grids;
  const char* package;
};
constexpr std::array<NamedGeoid, 2> kNamed{
    {{"egm96", "EGM96", "EGM96 height", {"us_nga_egm96_15.tif", "egm96_15.gtx"}, "proj-data"},
     {"egm2008", "EGM2008", "EGM2008 height", {"us_nga_egm08_25.tif", "egm08_25.gtx"}, nullptr}}};

ProjObject shiftBy(PJ_CONTEXT* context, const std::string& grid) {
  const std::string pipeline =
      "+proj=pipeline +step +proj=unitconvert +xy_in=deg +xy_out=rad +step +proj=vgridshift +grids=\"" + grid +
      "\" +multiplier=1 +step +proj=unitconvert +xy_in=rad +xy_out=deg";
  return ProjObject(proj_create(context, pipeline.c_str()));
}

Error missingGrid(const std::string& geoid, const std::string& grid, const std::string& package) {
  const std::string from_package = package.empty() ? "" : fmt::format("install Debian's package {}, or ", package);
  return {ErrorCode::kNotFound,
          fmt::format("{}: its grid {} is not on this machine; {}fetch it with projsync --file {}", geoid, grid,
                      from_package, grid)};
}

Error unreadableGrid(const std::string& file, const std::string& why) {
  return {ErrorCode::kMalformed, fmt::format("{}: not a grid of undulations that PROJ reads (.gtx, or GeoTIFF as in "
                                             "PROJ-data){}",
                                             file, why.empty() ? "" : "; PROJ says: " + why)};
}

std::string packageOf(const char* from_database) {
  return from_database != nullptr && *from_database != 0 ? "proj-data" : "";
}

// The first grid that an operation needs and that is not there; nothing if it has them all.
std::optional<Error> missingIn(PJ_CONTEXT* context, const PJ* operation, const std::string& name) {
  for (int i = 0; i < proj_coordoperation_get_grid_used_count(context, operation); ++i) {
    const char *grid = nullptr, *package = nullptr;
    int is_available = 0;
    if (proj_coordoperation_get_grid_used(context, operation, i, &grid, nullptr, &package, nullptr, nullptr, nullptr,
                                          &is_available) != 0 &&
        is_available == 0)
      return missingGrid(name, grid, packageOf(package));
  }
  return std::nullopt;
}

}  // namespace

Geoid::Geoid(std::unique_ptr<Parts> parts) : parts_(std::move(parts)) {}
Geoid::~Geoid() = default;
const std::string& Geoid::name() const { return parts_->name; }

Result<std::shared_ptr<Geoid>> Geoid::open(const std::string& choice) {
  auto parts = std::make_unique<Parts>();
  parts->context = newProjContext();
  for (const NamedGeoid& known : kNamed) {
    if (choice != known.choice) continue;
    parts->name = known.name;
    for (const char* grid : known.grids) {
      parts->to_ellipsoid = shiftBy(parts->context.get(), grid);
      parts->grid = grid;
      if (parts->to_ellipsoid) return std::shared_ptr<Geoid>(new Geoid(std::move(parts)));
    }
    return missingGrid(known.name, known.grids.front(), known.package != nullptr ? known.package : "");
  }
  const std::filesystem::path file = choice;
  std::error_code failed;
  if (!std::filesystem::is_regular_file(file, failed))
    return Error{ErrorCode::kNotFound,
                 choice +
                     ": neither ellipsoid, egm96 nor egm2008, and no such file; name a grid of undulations (.gtx, "
                     ".tif)"};
  if (choice.find_first_of("\",") != std::string::npos)
    return Error{ErrorCode::kUnsupported, choice + ": PROJ takes no names with quotes or commas; give it another name"};
  parts->grid = std::filesystem::absolute(file).string();
  parts->name = file.filename().string();
  parts->to_ellipsoid = shiftBy(parts->context.get(), parts->grid);
  if (!parts->to_ellipsoid) return unreadableGrid(choice, lastError(parts->context.get()));
  return std::shared_ptr<Geoid>(new Geoid(std::move(parts)));
}

Result<std::shared_ptr<Geoid>> Geoid::ofReferenceSystem(const std::string& wkt, const EarthBox& box) {
  auto parts = std::make_unique<Parts>();
  parts->context = newProjContext();
  PJ_CONTEXT* context = parts->context.get();
  const ProjObject compound(proj_create(context, wkt.c_str()));
  const ProjObject vertical(compound ? proj_crs_get_sub_crs(context, compound.get(), 1) : nullptr);
  if (!vertical) return Error{ErrorCode::kInvalidArgument, "a reference system without a vertical part"};
  parts->name = proj_get_name(vertical.get());
  for (const NamedGeoid& known : kNamed)
    if (parts->name == known.vertical_crs) return open(known.choice);
  // Longitudes and latitudes are WGS84's whatever the map's datum is, so the pair is made anew; heights in metres.
  const ProjObject wgs84(proj_create(context, "EPSG:4326")), earth(proj_create(context, "EPSG:4979"));
  const ProjObject metres(proj_crs_alter_cs_linear_unit(context, vertical.get(), "metre", 1, "EPSG", "9001"));
  const ProjObject from(
      proj_create_compound_crs(context, "heights", wgs84.get(), metres ? metres.get() : vertical.get()));
  const std::unique_ptr<PJ_OPERATION_FACTORY_CONTEXT, void (*)(PJ_OPERATION_FACTORY_CONTEXT*)> factory(
      proj_create_operation_factory_context(context, nullptr), proj_operation_factory_context_destroy);
  proj_operation_factory_context_set_allow_ballpark_transformations(context, factory.get(), 0);
  proj_operation_factory_context_set_area_of_interest(context, factory.get(), box.west, box.south, box.east, box.north);
  proj_operation_factory_context_set_spatial_criterion(context, factory.get(),
                                                       PROJ_SPATIAL_CRITERION_PARTIAL_INTERSECTION);
  proj_operation_factory_context_set_grid_availability_use(context, factory.get(), PROJ_GRID_AVAILABILITY_IGNORED);
  const std::unique_ptr<PJ_OBJ_LIST, void (*)(PJ_OBJ_LIST*)> ways(
      from && earth ? proj_create_operations(context, from.get(), earth.get(), factory.get()) : nullptr,
      proj_list_destroy);
  std::optional<Error> missing;
  for (int i = 0; ways && i < proj_list_get_count(ways.get()); ++i) {
    const ProjObject way(proj_list_get(context, ways.get(), i));
    std::optional<Error> lacks = missingIn(context, way.get(), parts->name);
    if (!lacks && proj_coordoperation_is_instantiable(context, way.get()) != 0) {
      parts->to_ellipsoid.reset(proj_normalize_for_visualization(context, way.get()));
      if (parts->to_ellipsoid) return std::shared_ptr<Geoid>(new Geoid(std::move(parts)));
    }
    if (lacks && !missing) missing = std::move(lacks);
  }
  if (missing) return *missing;
  return Error{ErrorCode::kUnsupported, parts->name +
                                            ": PROJ knows no transformation from it to the ellipsoid here; "
                                            "say by --vertical what the heights are above"};
}

void Geoid::undulations(std::span<const glm::dvec2> degrees, std::span<double> out) const {
  std::vector<PJ_COORD> places(out.size());
  for (size_t i = 0; i < out.size(); ++i) places[i] = proj_coord(degrees[i].x, degrees[i].y, 0, HUGE_VAL);
  PJ* way = parts_->to_ellipsoid.get();
  proj_trans_generic(way, PJ_FWD, &places[0].xyz.x, sizeof(PJ_COORD), places.size(), &places[0].xyz.y, sizeof(PJ_COORD),
                     places.size(), &places[0].xyz.z, sizeof(PJ_COORD), places.size(), nullptr, 0, 0);
  for (size_t i = 0; i < out.size(); ++i)
    out[i] = std::isfinite(places[i].xyz.z) ? places[i].xyz.z : std::numeric_limits<double>::quiet_NaN();
}

std::optional<GridLines> Geoid::lines() const {
  if (parts_->grid.empty()) return std::nullopt;
  const PJ_GRID_INFO info = proj_grid_info(parts_->grid.c_str());
  constexpr double kDegrees = 180 / std::numbers::pi;
  const GridLines lines{{info.lowerleft.lam * kDegrees, info.lowerleft.phi * kDegrees},
                        {info.cs_lon * kDegrees, info.cs_lat * kDegrees}};
  if (!(lines.step_degrees.x > 0 && lines.step_degrees.y > 0)) return std::nullopt;
  return lines;
}

}  // namespace foreland::terrain
