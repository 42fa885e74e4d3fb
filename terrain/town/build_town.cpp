#include "terrain/town/build_town.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <system_error>

#include "terrain/remesh/paint/paint.h"
#include "terrain/remesh/remesh.h"
#include "terrain/remesh/remeshed_surface.h"
#include "terrain/remesh/solids/find_solids.h"
#include "terrain/surface/bounds.h"
#include "terrain/surface_store/write_surface.h"
#include "terrain/town/buildings.h"
#include "terrain/town/street_plan.h"
#include "terrain/town/town_ground.h"

namespace foreland::terrain {

namespace {

constexpr int kAttempts = 3;           // at remeshing; more would come closer
constexpr uint32_t kTexels = 32;       // along a base edge
constexpr double kQuantum_m = 0.0005;  // of positions
constexpr double kOutskirts_m = 60, kMountains_m = 700;

// A folder that goes with what is in it, unless it was there before.
class ScratchFolder {
 public:
  explicit ScratchFolder(std::filesystem::path path) : path_(std::move(path)) {
    std::error_code failed;
    is_made_ = std::filesystem::create_directory(path_, failed);
  }
  ~ScratchFolder() {
    std::error_code failed;
    if (is_made_) std::filesystem::remove_all(path_, failed);
  }
  ScratchFolder(const ScratchFolder&) = delete;
  ScratchFolder& operator=(const ScratchFolder&) = delete;
  bool isMade() const { return is_made_; }
  std::filesystem::path operator/(const std::string& name) const { return path_ / name; }

 private:
  std::filesystem::path path_;
  bool is_made_ = false;
};

Result<TownModelReport> makeModel(const Building& building, const TownOptions& options,
                                  const std::filesystem::path& path) {
  const auto original = makeOriginal(building.model);
  if (!original.ok()) return Error{original.error().code, building.name + ": " + original.error().message};
  RemeshOptions how;
  how.base_triangles = options.base_triangles, how.levels = options.levels, how.attempts = kAttempts;
  how.threads = options.threads;
  const auto remeshed = remesh(*original, how);
  if (!remeshed.ok()) return remeshed.error();
  const auto surface = toSurface(*remeshed, proto::MeshRule::kQuadrisection, kQuantum_m);
  if (!surface.ok()) return surface.error();
  const auto painted = paint({building.model, {}}, *original, *remeshed, kTexels, options.threads);
  if (!painted.ok()) return painted.error();
  const auto records = computeBounds(*surface, {.threads = options.threads});
  const SolidsFound solids = findSolids(*surface);
  const auto id = writeSurface(path, {.surface = *surface,
                                      .records = records,
                                      .atlas = painted->atlas,
                                      .texels = painted->texels,
                                      .inner = solids.inner,
                                      .about = {building.name, {}, {}}});
  if (!id.ok()) return id.error();
  return TownModelReport{building.name, 0, solids.inner.solids.size(), solids.inner.volume_share,
                         largestError(surface->topology, records)};
}

}  // namespace

Result<TownReport> buildTown(const TownOptions& options, const Progress& progress) {
  if (options.buildings == 0 || options.buildings > proto::ObjectSet::kMaxObjects)
    return Error{ErrorCode::kInvalidArgument, "a town of " + std::to_string(options.buildings) + " buildings; 1 to " +
                                                  std::to_string(proto::ObjectSet::kMaxObjects) + " can be made"};
  const std::vector<Building> buildings = makeBuildings();
  const StreetPlan plan = planStreets(options.buildings, buildings, options.seed);
  const double radius_m = plan.radius_m + kOutskirts_m;
  auto ground =
      TownGround::create({.plain_radius_m = radius_m, .side_m = 2 * (radius_m + kMountains_m), .seed = options.seed});
  if (!ground.ok()) return ground.error();

  const ScratchFolder folder(options.output.string() + ".models");
  if (!folder.isMade())
    return Error{ErrorCode::kIo, options.output.string() +
                                     ".models: cannot be made, or is there already; remove it, or "
                                     "name another output"};
  TownReport report{{}, {}, radius_m};
  for (size_t i = 0; i < buildings.size(); ++i) {
    progress.report("models", static_cast<double>(i) / static_cast<double>(buildings.size()));
    if (!progress.keepGoing())
      return Error{ErrorCode::kIo, "stopped before the town was complete; nothing was written"};
    auto model = makeModel(buildings[i], options, folder / (buildings[i].name + ".fls"));
    if (!model.ok()) return model.error();
    report.models.push_back(std::move(*model));
  }
  progress.report("models", 1);
  BuildOptions scene{.output = options.output, .height_quantum_m = 0.01, .threads = options.threads};
  for (const PlacedBuilding& placed : plan.buildings) {
    ++report.models[placed.building].placed;
    scene.additions.objects.push_back({.model = folder / (buildings[placed.building].name + ".fls"),
                                       .at = (*ground)->middle() + placed.at,
                                       .height_m = -kFoundation_m,
                                       .heading_deg = placed.heading_rad * 180 / std::numbers::pi});
  }
  auto built = buildScene(**ground, scene, progress);
  if (!built.ok()) return built.error();
  report.scene = std::move(*built);
  return report;
}

}  // namespace foreland::terrain
