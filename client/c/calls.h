// What every function of the C interface does beside its own work: refuses what makes no sense, and lets no exception
// out. Any thread; a thread's last error is its own.
#pragma once

#include <string_view>

#include "base/result.h"
#include "client/c/foreland.h"
#include "client/c/structs.h"
#include "client/c/terrain.h"

struct ForelandTerrain {
  foreland::client::Terrain terrain;
};

namespace foreland::client {

// Why the last call in this thread failed; as much of it as there is room for.
const char* lastError();
// Gives `status`, with sentences that say why.
ForelandStatus refuse(ForelandStatus status, std::string_view why) noexcept;
ForelandStatus refuse(const Error& error) noexcept;
// Of an exception that is being handled.
ForelandStatus refuseException() noexcept;

inline constexpr std::string_view kNoTerrain = "A pointer that must not be NULL is NULL.";
inline constexpr std::string_view kNoSize = "The size of a struct is not set: begin with FORELAND_INIT.";
inline constexpr std::string_view kNoScene = "No session has begun yet: wait for FORELAND_EVENT_SCENE.";

template <class Work>
ForelandStatus guarded(const Work& work) noexcept {
  try {
    return work();
  } catch (...) { return refuseException(); }
}

// `work` with the terrain, unless one of the pointers is null.
template <class Work, class... Pointers>
ForelandStatus withTerrain(ForelandTerrain* terrain, const Work& work, Pointers... pointers) noexcept {
  if (terrain == nullptr || ((pointers == nullptr) || ...)) return refuse(FORELAND_ARGUMENT, kNoTerrain);
  return guarded([&]() -> ForelandStatus { return work(terrain->terrain); });
}

// Likewise, of what needs a scene.
template <class Work, class... Pointers>
ForelandStatus withScene(ForelandTerrain* terrain, const Work& work, Pointers... pointers) noexcept {
  return withTerrain(
      terrain,
      [&](Terrain& t) -> ForelandStatus {
        if (!t.hasScene()) return refuse(FORELAND_NO_SCENE, kNoScene);
        return work(t);
      },
      pointers...);
}

inline ForelandStatus statusOf(const Status& status) noexcept {
  return status.ok() ? FORELAND_OK : refuse(status.error());
}

}  // namespace foreland::client
