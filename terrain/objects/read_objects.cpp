#include <algorithm>
#include <cmath>
#include <cstring>

#include "terrain/objects/placed_objects.h"
#include "terrain/objects/section_bytes.h"
#include "terrain/store/bilinear.h"

namespace foreland::terrain {

namespace {

Error damaged(const std::string& what) {
  return {ErrorCode::kMalformed, "the scene's objects: " + what + "; build or copy the scene again"};
}

template <class T>
T readAt(ByteSpan bytes, uint64_t offset) {
  T value;
  std::memcpy(&value, bytes.data() + offset, sizeof(value));
  return value;
}

}  // namespace

Status checkModel(const MappedSurface& surface) {
  const auto unfit = [](const char* what) { return Error{ErrorCode::kUnsupported, what}; };
  const proto::AtlasLayout atlas = surface.atlas();
  if (surface.errorShape() != proto::ErrorShape::kSpheroid)
    return unfit("its bounds are Hoppe's shapes, which are for comparison");
  if (atlas.side > 0 && atlas != proto::AtlasLayout::of(atlas.faces, atlas.side))
    return unfit("its image is laid out in another way");
  return {};
}

Result<proto::ObjectModel> modelOf(const MappedSurface& surface, const proto::Epochs& epochs) {
  proto::ObjectModel model{surface.topology().shape(),
                           surface.quantumMetres(),
                           {surface.basePositions().begin(), surface.basePositions().end()},
                           surface.atlas().side};
  for (const Time& time : surface.poseTimes()) {
    const auto isThen = [&](const proto::Epoch& epoch) { return epoch.time == time; };
    const auto epoch = std::ranges::find_if(epochs.all(), isThen);
    if (epoch == epochs.all().end())
      return Error{ErrorCode::kInvalidArgument, "its pose " + std::to_string(model.pose_epochs.size() + 1) + " of " +
                                                    std::to_string(surface.poseTimes().size()) +
                                                    " is at none of the scene's epochs"};
    model.pose_epochs.push_back(static_cast<uint32_t>(epoch - epochs.all().begin()));
  }
  model.base_moves.assign(surface.baseMoves().begin(), surface.baseMoves().end());
  return model;
}

proto::GroundRise riseAt(const Scene& scene, const glm::dvec3& position) {
  const EpochTable& table = scene.epochs();
  if (table.epochs().empty()) return {};
  const proto::GridShape& shape = scene.grid().shape();
  const proto::LatticePosition p = proto::FrameTransform(scene.frame()).toLattice(position);
  if (!std::isfinite(p.x) || !std::isfinite(p.y)) return {};
  const double x = std::clamp(p.x, 0.0, shape.samples_x - 1.0), y = std::clamp(p.y, 0.0, shape.samples_y - 1.0);
  std::vector<int32_t> quanta;
  for (uint32_t epoch = 0; epoch < table.epochs().size(); ++epoch) {
    const auto at = [&](uint32_t at_x, uint32_t at_y) {
      const proto::NodeId v = proto::NodeId::at(at_x, at_y);
      return table.epochs().mayMove(epoch, v) ? table.offset(epoch, scene.grid(), v) : 0;
    };
    quanta.push_back(static_cast<int32_t>(std::lround(bilinear(shape.samples_x, shape.samples_y, x, y, at))));
  }
  if (std::all_of(quanta.begin(), quanta.end(), [](int32_t q) { return q == 0; })) return {};
  return {std::move(quanta), table.epochs(), scene.frame(), position};
}

Result<PlacedObjects> readObjects(const std::shared_ptr<const Scene>& scene) {
  const ByteSpan bytes = scene->objectSection();
  PlacedObjects objects;
  if (bytes.empty()) return objects;
  if (bytes.size() < sizeof(ObjectSectionStart)) return damaged("cut short");
  const auto start = readAt<ObjectSectionStart>(bytes, 0);
  if (start.models > proto::ObjectSet::kMaxModels || start.objects > proto::ObjectSet::kMaxObjects)
    return damaged("more than a scene holds");
  const uint64_t table = sizeof(start) + start.objects * sizeof(StoredPlacement);
  if (bytes.size() < table + start.models * sizeof(StoredModel)) return damaged("cut short");
  std::vector<proto::ObjectModel> models;
  for (uint32_t i = 0; i < start.models; ++i) {
    const auto place = readAt<StoredModel>(bytes, table + i * sizeof(StoredModel));
    if (place.offset % kPageBytes != 0 || place.offset > bytes.size() || place.bytes > bytes.size() - place.offset)
      return damaged("model " + std::to_string(i) + " is not where it belongs");
    auto surface = MappedSurface::of(bytes.subspan(place.offset, place.bytes), "model " + std::to_string(i), scene);
    if (!surface.ok()) return surface.error();
    if (Status s = checkModel(**surface); !s.ok())
      return damaged("model " + std::to_string(i) + ": " + s.error().message);
    auto model = modelOf(**surface, scene->epochs().epochs());
    if (!model.ok()) return damaged("model " + std::to_string(i) + ": " + model.error().message);
    models.push_back(std::move(*model));
    objects.models.push_back(std::move(*surface));
  }
  std::vector<proto::ObjectPlacement> placements;
  for (uint32_t i = 0; i < start.objects; ++i) {
    const auto p = readAt<StoredPlacement>(bytes, sizeof(start) + i * sizeof(StoredPlacement));
    const glm::dvec3 position(p.position[0], p.position[1], p.position[2]);
    placements.push_back({p.model, position,
                          glm::dquat(p.orientation[0], p.orientation[1], p.orientation[2], p.orientation[3]), p.scale,
                          riseAt(*scene, position)});
  }
  auto set = proto::ObjectSet::create(std::move(models), std::move(placements), scene->epochs().epochs());
  if (!set.ok()) return damaged(set.error().message);
  objects.set = std::move(*set);
  return objects;
}

}  // namespace foreland::terrain
