// Which area of a large scene a place is in: for the address of a viewer's next connection, so that a proxy before
// several servers leads viewers of the same ground to the same server, whose memory has it (docs/decisions/0026). Areas
// are squares of the lattice, and coarse: nobody needs to be told more of where somebody is. Pure; any thread; portable
// to WebAssembly.
#pragma once

#include <cstdint>
#include <glm/vec2.hpp>
#include <optional>

#include "proto/topology/grid.h"

namespace foreland::client {

// An area is so many of the finest lattice's steps a side: some 50 MB of a scene file, or 20 km of samples 10 m apart.
inline constexpr uint32_t kAreaLog2 = 11;

// The number of the area of a lattice position: areas are counted along rows from west to east, rows from south to
// north; a globe's faces lie side by side in a row, as they do in its lattice. Positions outside of the data are in the
// area nearest to them. Less than 2^29. Nothing of a scene that is small, which is one area, nor of a position that is
// not finite.
std::optional<uint32_t> areaOf(const proto::GridShape& shape, const glm::dvec2& lattice);

}  // namespace foreland::client
