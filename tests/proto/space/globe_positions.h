// Positions on globes as one number, the same in every build: native code and WebAssembly place vertices, and find
// places again, to the bit (proto/space/cube_map.h).
#pragma once

#include <bit>
#include <cstdint>

#include "base/fnv1a.h"
#include "base/rng.h"
#include "proto/space/frame.h"

namespace foreland::proto {

// Of kGlobePositions points.
inline constexpr uint32_t kGlobePositions = 1'000'000;
inline constexpr uint64_t kHashOfGlobePositions = 0xa7e08ea6f62de431;

// Of so many vertices of the earth at any height, and of the place of each as it is found from its position.
inline uint64_t hashOfGlobePositions(uint32_t count) {
  Frame frame;
  frame.kind = FrameKind::kGlobe;
  frame.face_steps = 1u << 21;
  const FrameTransform earth(frame);
  Rng rng(20);
  Fnv1a hash;
  for (uint32_t i = 0; i < count; ++i) {
    const auto x = static_cast<uint32_t>(rng.below(6 * frame.face_steps + 1)),
               y = static_cast<uint32_t>(rng.below(frame.face_steps + 1));
    const glm::dvec3 p = earth.vertexOfGlobe(x, y, 0.1 * static_cast<double>(rng.below(200'000)) - 11'000);
    const LatticePosition back = earth.toLattice(p);
    for (const double value : {p.x, p.y, p.z, back.x, back.y, back.height_m})
      hash.addWord(std::bit_cast<uint64_t>(value));
  }
  return hash.value();
}

}  // namespace foreland::proto
