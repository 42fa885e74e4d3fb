// How the section of objects begins, as it lies in the file. Change docs/SCENE_FORMAT.md and kFormatVersion with it.
#pragma once

#include <cstdint>
#include <type_traits>

namespace foreland::terrain {

// Followed by `objects` StoredPlacement, `models` StoredModel, and the surface files at the offsets that these state.
struct ObjectSectionStart {
  uint32_t models = 0, objects = 0;
};
struct StoredPlacement {
  double position[3];     // scene frame, metres
  double orientation[4];  // w, x, y, z
  double scale;
  uint32_t model;
  uint32_t reserved;
};
struct StoredModel {
  uint64_t offset, bytes;  // from the section's begin; the offset is a multiple of a page
};
static_assert(sizeof(StoredPlacement) == 72 && std::is_trivially_copyable_v<StoredPlacement>);

}  // namespace foreland::terrain
