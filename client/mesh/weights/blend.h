// How a client blends the surfaces of keyframes, that is, which weights w(v) of THEORY section 2 it draws with.
//   keyframe    all nodes change together, from one keyframe to the next (P, theorem 1): every frame keeps the error
//               guarantee
//   geomorph    per-node morph timing (S 3.5; morph_timing.h): changes are slower where they would show. A node may
//               then arrive after the keyframe that needs it, so frames are not guaranteed to keep the tolerance
//   b-spline-2  interpolation of order 2 (P, equation 1): the last three keyframes, with the weights of the uniform
//               B-spline. Every frame keeps the guarantee, and nothing changes its velocity where meshes meet
//   b-spline-3  of order 3: the last four, and accelerations are continuous as well
// A node changes by a time of its own, or all change by the order, so geomorphs have no order. Value; any thread.
#pragma once

#include <cstdint>
#include <optional>
#include <string_view>

namespace foreland::client {

enum class Blend : uint8_t { kKeyframe = 0, kGeomorph = 1, kSpline2 = 2, kSpline3 = 3 };

inline constexpr Blend kBlends[] = {Blend::kKeyframe, Blend::kGeomorph, Blend::kSpline2, Blend::kSpline3};

inline constexpr const char* name(Blend blend) {
  constexpr const char* kNames[] = {"keyframe", "geomorph", "b-spline-2", "b-spline-3"};
  return kNames[static_cast<size_t>(blend)];
}

// The blend of this name; nullopt if there is none.
inline std::optional<Blend> blendNamed(std::string_view text) {
  for (Blend blend : kBlends)
    if (text == name(blend)) return blend;
  return std::nullopt;
}

// A frame blends one keyframe more.
inline constexpr uint32_t orderOf(Blend blend) {
  return blend == Blend::kSpline2 ? 2 : blend == Blend::kSpline3 ? 3 : 1;
}

}  // namespace foreland::client
