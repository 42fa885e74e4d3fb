#include <cstring>

#include "terrain/objects/placed_objects.h"
#include "terrain/objects/section_bytes.h"

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

proto::ObjectModel modelOf(const MappedSurface& surface) {
  return {surface.topology().shape(),
          surface.quantumMetres(),
          {surface.basePositions().begin(), surface.basePositions().end()},
          surface.atlas().side};
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
    models.push_back(modelOf(**surface));
    objects.models.push_back(std::move(*surface));
  }
  std::vector<proto::ObjectPlacement> placements;
  for (uint32_t i = 0; i < start.objects; ++i) {
    const auto p = readAt<StoredPlacement>(bytes, sizeof(start) + i * sizeof(StoredPlacement));
    placements.push_back({p.model,
                          {p.position[0], p.position[1], p.position[2]},
                          glm::dquat(p.orientation[0], p.orientation[1], p.orientation[2], p.orientation[3]),
                          p.scale});
  }
  auto set = proto::ObjectSet::create(std::move(models), std::move(placements));
  if (!set.ok()) return damaged(set.error().message);
  objects.set = std::move(*set);
  return objects;
}

}  // namespace foreland::terrain
