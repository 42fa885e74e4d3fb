// Sections as bytes, about one bit a node: what a client sends to resume after its connection was lost, to the same
// server or another with the same scene. The terrain's section comes first, then each object's. Level by level, one bit
// for each node whose parents are in the section, ascending: is the node in it, too? The context is the level and the
// three bits before. Then likewise which other nodes of the terrain the client knows, as far as their parents are known
// or in the section; and of each page with such nodes the least error that a node was asked about. Any bytes end in
// closed sections or in an Error, in time and memory linear in the bytes and the objects' base meshes. Pure; any
// thread; portable to WebAssembly.
#pragma once

#include "base/bytes.h"
#include "base/result.h"
#include "proto/refine/memory/node_memory.h"
#include "proto/refine/surface/objects.h"
#include "proto/section/section.h"
#include "proto/topology/grid.h"

namespace foreland::proto {

// All that a client holds, in the order of the objects; closed.
struct HeldSections {
  Section terrain;
  std::vector<Section> objects;
  // Of the terrain, ascending. Nodes of the section are known whether or not a page says so, with 0 as the least error
  // asked about if their page is not here. Settled errors and radii are not sent.
  std::vector<KnownPage> known = {};
  bool operator==(const HeldSections&) const = default;
};
uint32_t fingerprint(const HeldSections& sections);

// Returns the known pages as decodeSections() has them: with the section's nodes, without those nodes whose parents are
// not known, and without what is not sent.
std::vector<KnownPage> encodeSections(const GridTopology& grid, const ObjectSet& objects, const HeldSections& sections,
                                      Bytes& out);
// Reads them to the end of `bytes`; at most `max_nodes` in all sections and as many that are known beside them.
Result<HeldSections> decodeSections(const GridTopology& grid, const ObjectSet& objects, ByteSpan bytes,
                                    size_t max_nodes);

}  // namespace foreland::proto
