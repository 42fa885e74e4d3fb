// How a client blends the surfaces of two keyframes: which of the weights of DESIGN section 2 it takes.
//   keyframe  every node on one clock, that of the two keyframes (P, theorem 1): keeps the promise in every frame
//   geomorph  every node on its own clock (S 3.5; morph_clock.h): changes are slower where they would show, and what
//             comes late is late, so no frame is promised the tolerance
// Value; any thread.
#pragma once

#include <cstdint>
#include <optional>
#include <string_view>

namespace foreland::client {

enum class Blend : uint8_t { kKeyframe = 0, kGeomorph = 1 };

inline constexpr const char* name(Blend blend) { return blend == Blend::kKeyframe ? "keyframe" : "geomorph"; }

// Nothing if it is none.
inline std::optional<Blend> blendNamed(std::string_view text) {
  for (Blend blend : {Blend::kKeyframe, Blend::kGeomorph})
    if (text == name(blend)) return blend;
  return std::nullopt;
}

}  // namespace foreland::client
