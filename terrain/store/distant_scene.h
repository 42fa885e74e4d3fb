// A scene in a store that answers ranges (terrain/fetch), of which a bounded part is there: a Scene whose pages() all
// are in the file, but whose supply() must be asked before one is read. What is always needed is fetched when the scene
// is opened: all but most of the nodes and the tiles. Any thread.
#pragma once

#include <memory>
#include <string>

#include "terrain/store/distant/chunk_cache.h"
#include "terrain/store/scene.h"

namespace foreland::terrain {

// `sums` are the bytes of its checksums (sums.h), and `name` what errors call the scene. Reads from `source` by the
// calling thread. An Error if these are not of the scene, or if it is one that must be copied to be served: one with
// coded pages or epochs. The caller starts the fetching: supply()->cache().start().
Result<std::shared_ptr<const Scene>> openDistant(std::shared_ptr<RangeSource> source, ByteSpan sums,
                                                 const std::string& name, ChunkCacheOptions options);

}  // namespace foreland::terrain
