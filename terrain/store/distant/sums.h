// Checksums of a scene file's chunks, in a small file beside it (`foreland sums`): what a server that reads the scene
// from a store holds each chunk against before it uses it. docs/SCENE_FORMAT.md describes the file. Pure but for
// sumsOf(); any thread.
#pragma once

#include <algorithm>
#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "base/bytes.h"
#include "base/result.h"

namespace foreland::terrain {

struct SceneSums {
  // Of chunks: whole pages of the file; small ones are quicker there, large ones need fewer checksums.
  static constexpr uint64_t kLeastChunk = 4096, kMostChunk = uint64_t{1} << 24, kUsualChunk = 65536;

  uint64_t chunk_bytes = kUsualChunk;
  uint64_t file_bytes = 0;
  uint64_t scene_id = 0;
  std::vector<uint64_t> sums;  // XXH64 of each chunk; the last one may be short

  uint64_t begin(uint64_t chunk) const { return chunk * chunk_bytes; }
  uint64_t bytesOf(uint64_t chunk) const { return std::min(chunk_bytes, file_bytes - begin(chunk)); }
  bool isSound(uint64_t chunk, ByteSpan bytes) const;
};

// Reads the whole scene file. An Error if it is none, or if `chunk_bytes` is no power of two within the bounds above.
Result<SceneSums> sumsOf(const std::filesystem::path& scene, uint64_t chunk_bytes = SceneSums::kUsualChunk);

Bytes encode(const SceneSums& sums);
// Accepts any bytes. Errors call them `name`.
Result<SceneSums> decodeSums(ByteSpan bytes, const std::string& name);
// The most bytes that checksums of a file may take.
inline constexpr uint64_t kMostSumsBytes = uint64_t{1} << 30;

// Where the checksums of a scene lie: its name with ".sums" after it.
inline std::string sumsBeside(const std::string& scene) { return scene + ".sums"; }

}  // namespace foreland::terrain
