#include "terrain/store/distant_scene.h"

#include <algorithm>
#include <utility>

#include "terrain/store/distant/page_supply.h"
#include "terrain/store/mapped_scene.h"

namespace foreland::terrain {

namespace {

Error refusal(const std::string& name, ErrorCode code, const std::string& what) { return {code, name + ": " + what}; }

// Of the nodes' records, the coarsest, which every view needs; no more than comes soon, for nobody is served before.
uint64_t coarseBytes(const ChunkCache& cache, const SectionRange& nodes) {
  constexpr uint64_t kMost = uint64_t{4} << 20;
  constexpr double kSoon_s = 4;
  const uint64_t chunk_bytes = cache.sums().chunk_bytes;
  const double rate = cache.bytesPerSecond();
  const uint64_t soon = rate > 0 ? static_cast<uint64_t>(std::min(kSoon_s * rate, static_cast<double>(kMost))) : kMost;
  return std::min({nodes.bytes, std::max(soon, chunk_bytes), cache.counts().capacity * chunk_bytes / 8});
}

// All but finer nodes and the tiles' bytes, whose directory is before them.
Status keepTheRest(ChunkCache& cache, const FileHeader& header) {
  const SectionRange& nodes = header.sections[kNodes];
  if (Status s = cache.keep(0, nodes.offset + coarseBytes(cache, nodes)); !s.ok()) return s;
  const uint64_t after_nodes = nodes.offset + nodes.bytes, end = header.file_bytes;
  if (header.tiles.bytes == 0) return cache.keep(after_nodes, end - after_nodes);
  if (Status s = cache.keep(after_nodes, header.tiles.offset - after_nodes); !s.ok()) return s;
  const uint64_t tiles_end = header.tiles.offset + header.tiles.bytes;
  if (Status s = cache.keep(tiles_end, end - tiles_end); !s.ok()) return s;
  if (Status s = cache.keep(header.tiles.offset, std::min(kPageBytes, header.tiles.bytes)); !s.ok()) return s;
  const uint64_t directory =
      TileTable::directoryBytes(sectionOf<uint8_t>(cache.file(), header.tiles), getFrame(header).face_steps);
  return cache.keep(header.tiles.offset, std::min(directory, header.tiles.bytes));
}

// Whether the sections lie in the file, one after the other.
bool arePlaced(const FileHeader& header) {
  const SectionRange& nodes = header.sections[kNodes];
  const auto isInFile = [&](const SectionRange& range, uint64_t least) {
    return range.offset >= least && range.offset <= header.file_bytes &&
           range.bytes <= header.file_bytes - range.offset;
  };
  if (!isInFile(nodes, kPageBytes)) return false;
  return header.tiles.bytes == 0 || isInFile(header.tiles, nodes.offset + nodes.bytes);
}

}  // namespace

Result<std::shared_ptr<const Scene>> openDistant(std::shared_ptr<RangeSource> source, ByteSpan sums,
                                                 const std::string& name, ChunkCacheOptions options) {
  auto decoded = decodeSums(sums, sumsBeside(name));
  if (!decoded) return decoded.error();
  const SceneSums of = *decoded;
  if (of.file_bytes < kPageBytes) return refusal(name, ErrorCode::kMalformed, "it is no scene");
  auto made = ChunkCache::create(std::move(*decoded), std::move(source), std::move(options));
  if (!made) return made.error();
  std::shared_ptr<ChunkCache> cache = std::move(*made);
  const auto named = [&](const Error& error) { return Error{error.code, name + ": " + error.message}; };
  if (Status s = cache->keep(0, kPageBytes); !s.ok()) return named(s.error());
  const auto header = readHeader<FileHeader>(cache->file(), name);
  if (!header) return header.error();
  if (header->scene_id != of.scene_id)
    return refusal(name, ErrorCode::kMalformed,
                   "its checksums are those of another scene; make them anew, by `foreland sums`");
  if (!arePlaced(*header)) return refusal(name, ErrorCode::kMalformed, "its sections are not where they belong");
  if (header->page_coding != PageCoding::kPlain || header->epochs.bytes > 0)
    return refusal(
        name, ErrorCode::kUnsupported,
        "a scene with coded pages or epochs cannot be served from a distance; copy it here, or build it with "
        "--pages plain");
  if (Status s = keepTheRest(*cache, *header); !s.ok()) return named(s.error());
  auto supply = std::make_shared<const PageSupply>(cache, header->sections[kNodes]);
  auto scene = MappedScene::of(cache->file(), name, cache, kDefaultPageCacheBytes, std::move(supply));
  if (!scene) return scene.error();
  return std::shared_ptr<const Scene>(std::move(*scene));
}

}  // namespace foreland::terrain
