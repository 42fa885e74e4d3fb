// Sections as bytes, about one bit a node: what a client sends to resume after its connection was lost, to the same
// server or another with the same scene. The terrain's section comes first, then each object's. Level by level, one bit
// for each node whose parents are in the section, ascending: is the node in it, too? The context is the level and the
// three bits before.
// Any bytes end in closed sections or in an Error, in time and memory linear in the bytes and the objects' base meshes.
// Pure; any thread; portable to WebAssembly.
#pragma once

#include "base/bytes.h"
#include "base/result.h"
#include "proto/refine/objects.h"
#include "proto/section/section.h"
#include "proto/topology/grid.h"

namespace foreland::proto {

// All that a client holds, in the order of the objects; closed.
struct HeldSections {
  Section terrain;
  std::vector<Section> objects;
  bool operator==(const HeldSections&) const = default;
};
uint32_t fingerprint(const HeldSections& sections);

void encodeSections(const GridTopology& grid, const ObjectSet& objects, const HeldSections& sections, Bytes& out);
// Reads them to the end of `bytes`; at most `max_nodes` in all.
Result<HeldSections> decodeSections(const GridTopology& grid, const ObjectSet& objects, ByteSpan bytes,
                                    size_t max_nodes);

}  // namespace foreland::proto
