#include "server/session/world.h"

#include <algorithm>
#include <array>
#include <utility>

namespace foreland::server {

namespace {

constexpr std::array kOcclusionNames{"off", "auto", "on"};

}  // namespace

World::World(std::shared_ptr<const terrain::Scene> scene, SceneObjects objects, const SightSetup& setup)
    : hierarchy(std::move(scene), proto::ErrorBound::kSpheroid, std::move(objects)),
      sight(std::make_unique<SightSupply>(hierarchy, setup.building,
                                          hierarchy.scene().supply() ? SightOptions{0} : setup.options)),
      tours(std::make_unique<TourPlans>(hierarchy.scene())) {
  if (hierarchy.epochs().epochs().blend() != proto::EpochBlend::kLinear)
    motion = std::make_unique<const GroundMotion>(hierarchy);
  if (hierarchy.scene().supply()) return;  // what is prepared reads all of the ground
  if (hierarchy.scene().tiles().layers().empty() || !hierarchy.epochs().epochs().empty()) return;
  if (hierarchy.grid().isCube()) return;  // squares of the ground know no seams; tiles' own bounds do
  ground = std::make_shared<const SceneGround>(SceneGround{GroundSquares(hierarchy), HorizonGrid::of(hierarchy)});
}

const char* name(Occlusion occlusion) { return kOcclusionNames[static_cast<size_t>(occlusion)]; }

std::optional<Occlusion> occlusionNamed(std::string_view name) {
  const auto at = std::ranges::find(kOcclusionNames, name);
  if (at == kOcclusionNames.end()) return std::nullopt;
  return static_cast<Occlusion>(at - kOcclusionNames.begin());
}

Result<std::shared_ptr<const World>> openWorld(std::shared_ptr<const terrain::Scene> scene, Occlusion occlusion,
                                               const SightSetup& sight) {
  auto objects = objectsOf(scene);
  if (!objects) return objects.error();
  auto world = std::make_shared<World>(std::move(scene), std::move(*objects), sight);
  if (world->hierarchy.scene().supply() && occlusion == Occlusion::kOn)
    return Error{ErrorCode::kUnsupported,
                 "what ridges of a scene at a distance hide is not known, for most of it is not here; serve it without "
                 "--occlusion on, or copy it here"};
  if (occlusion != Occlusion::kOff && !world->hierarchy.scene().supply()) {
    const auto building = sight.building == SightSupply::Building::kOnAThread ? GlobeGrids::Building::kOnAThread
                                                                              : GlobeGrids::Building::kByTheCaller;
    auto shared = SceneOcclusion::create(world->hierarchy, world->ground ? world->ground->grid : nullptr, building);
    if (!shared && occlusion == Occlusion::kOn) return shared.error();
    if (shared) world->occlusion = std::move(*shared);
  }
  return std::shared_ptr<const World>(std::move(world));
}

proto::Welcome welcomeTo(const Hierarchy& hierarchy) {
  const terrain::Scene& scene = hierarchy.scene();
  proto::Welcome w;
  w.scene_id = scene.id();
  w.title = scene.origin().title;
  w.crs = scene.origin().crs_wkt;
  w.frame = scene.frame();
  w.shape = scene.grid().shape();
  w.lowest = scene.heightRange().lowest;
  w.highest = scene.heightRange().highest;
  w.corner_heights.assign(scene.cornerHeights().begin(), scene.cornerHeights().end());
  w.centre_heights.assign(scene.centreHeights().begin(), scene.centreHeights().end());
  w.memory_bytes = proto::kDefaultMemoryBytes;
  w.models = hierarchy.objects().set.models();
  w.objects = hierarchy.objects().set.placements();
  const terrain::EpochTable& epochs = hierarchy.epochs();
  w.epochs.assign(epochs.epochs().all().begin(), epochs.epochs().all().end());
  w.epoch_blend = epochs.epochs().blend();
  w.base_offsets.assign(epochs.baseOffsets().begin(), epochs.baseOffsets().end());
  w.max_offset = hierarchy.maxOffset();
  w.tile_layers.assign(scene.tiles().layers().begin(), scene.tiles().layers().end());
  w.vertical = scene.vertical();
  w.vertical.undulations = proto::thinned(scene.vertical().undulations, proto::kMaxUndulationSide);
  return w;
}

}  // namespace foreland::server
