// How a client blends the surfaces of two keyframes, that is, which weights w(v) of DESIGN section 2 it draws with.
//   keyframe  all nodes change together, from one keyframe to the next (P, theorem 1): every frame keeps the error
//             guarantee
//   geomorph  per-node morph timing (S 3.5; morph_timing.h): changes are slower where they would show. A node may then
//             arrive after the keyframe that needs it, so frames are not guaranteed to keep the tolerance
// Value; any thread.
#pragma once

#include <cstdint>
#include <optional>
#include <string_view>

namespace foreland::client {

enum class Blend : uint8_t { kKeyframe = 0, kGeomorph = 1 };

inline constexpr const char* name(Blend blend) { return blend == Blend::kKeyframe ? "keyframe" : "geomorph"; }

// The blend of this name; nullopt if there is none.
inline std::optional<Blend> blendNamed(std::string_view text) {
  for (Blend blend : {Blend::kKeyframe, Blend::kGeomorph})
    if (text == name(blend)) return blend;
  return std::nullopt;
}

}  // namespace foreland::client
