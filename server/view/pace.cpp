#include "server/view/pace.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <glm/common.hpp>
#include <glm/geometric.hpp>

namespace foreland::server {

Pace::Pace(const terrain::Scene& scene, glm::dvec2 spacing_m, double fall_m) : spacing_m_(spacing_m), fall_m_(fall_m) {
  constexpr uint32_t kSide = proto::PageBlock::kSide;
  const proto::GridShape& shape = scene.grid().shape();
  const double whole_step = std::ldexp(1.0, static_cast<int>(shape.sparse_levels / 2));
  for (const proto::PageBlock& block : scene.pages().blocks()) {
    if (block.level() % 2 != 0) continue;  // of sides, which lie where centres are
    glm::uvec2 low(kSide), high(0);        // pages
    for (uint32_t i = 0; i < kSide * kSide; ++i)
      if (block.bits[i / 64] >> (i % 64) & 1) {
        low = glm::min(low, glm::uvec2(i % kSide, i / kSide));
        high = glm::max(high, glm::uvec2(i % kSide, i / kSide) + 1u);
      }
    const double step = std::ldexp(1.0, static_cast<int>(shape.root_log2) - 1 - block.level() / 2);
    const double page = step * proto::GridTopology::kTileSide;
    const glm::dvec2 first(block.column() * kSide, block.row() * kSide);
    fine_.push_back(
        {page * (first + glm::dvec2(low)), page * (first + glm::dvec2(high)), std::sqrt(step / whole_step)});
  }
}

double Pace::at(glm::dvec2 lattice) const {
  double pace = 1;
  for (const Fine& f : fine_) {
    const glm::dvec2 beyond = glm::max(glm::max(f.low - lattice, lattice - f.high), glm::dvec2(0));
    pace = std::min(pace, f.pace + glm::length(spacing_m_ * beyond) / fall_m_);
  }
  return pace;
}

}  // namespace foreland::server
