// The undulations of a geoid over a scene, as a grid on its lattice. Pure but for the geoid; one thread.
#pragma once

#include <functional>
#include <glm/vec2.hpp>
#include <optional>
#include <span>

#include "proto/space/vertical.h"

namespace foreland::terrain {

// Undulations at lattice positions, metres; NaN where there is none.
using UndulationsAt = std::function<void(std::span<const glm::dvec2> lattice, std::span<double> out)>;

// Where the geoid's own lines are on the lattice: one of them, and the step from line to line.
struct LatticeLines {
  glm::dvec2 first, step;
};

// A grid over width x height samples: on the geoid's own lines, between which it is bilinear as the geoid is; else, and
// where these would be too many, halved until it is within kGoodEnough_m of the geoid in the middle of every cell and
// side, or 1025 a side. Its max_error_m is measured there. Nothing if an undulation over the samples is not known.
inline constexpr double kGoodEnough_m = 0.002;
std::optional<proto::UndulationGrid> fitUndulations(uint32_t width, uint32_t height,
                                                    const std::optional<LatticeLines>& lines, const UndulationsAt& at);

}  // namespace foreland::terrain
