// A section as bytes, about one bit a node: what a client presents to go on with it after its connection was lost, to
// the same server or another with the same scene. Level by level, for each node whose parents are in the section,
// ascending: is it, too? Coded with the level and the answers just before as context. Any bytes end in a closed section
// or in an Error, in time and memory linear in the bytes. Pure; any thread; portable to WebAssembly.
#pragma once

#include "base/bytes.h"
#include "base/result.h"
#include "proto/grid.h"
#include "proto/section.h"

namespace foreland::proto {

// Appends a closed section.
void encodeSection(const GridTopology& topology, const Section& section, Bytes& out);
// Reads one to the end of `bytes`; at most `max_nodes`.
Result<Section> decodeSection(const GridTopology& topology, ByteSpan bytes, size_t max_nodes);

}  // namespace foreland::proto
