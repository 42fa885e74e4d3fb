#include "terrain/store/distant/sums.h"

#include <array>
#include <bit>
#include <cstring>

#include "terrain/store/file/checksum.h"
#include "terrain/store/file/mapped_file.h"

namespace foreland::terrain {

namespace {

struct SumsHeader {
  std::array<char, 8> magic{'F', 'L', 'S', 'U', 'M', 'S', '\0', '\0'};
  uint32_t version = 1;
  uint32_t chunk_bytes = 0;
  uint64_t file_bytes = 0;
  uint64_t scene_id = 0;
  uint64_t checksum = 0;  // XXH64 of this header with the field zero, then, seeded by it, of the checksums
};
static_assert(sizeof(SumsHeader) == 40 && std::is_trivially_copyable_v<SumsHeader>);

bool isChunkSize(uint64_t bytes) {
  return std::has_single_bit(bytes) && bytes >= SceneSums::kLeastChunk && bytes <= SceneSums::kMostChunk;
}

ByteSpan bytesOf(const std::vector<uint64_t>& sums) {
  return {reinterpret_cast<const uint8_t*>(sums.data()), sums.size() * sizeof(uint64_t)};
}

uint64_t checksumOf(SumsHeader header, const std::vector<uint64_t>& sums) {
  header.checksum = 0;
  return xxh64(bytesOf(sums), xxh64({reinterpret_cast<const uint8_t*>(&header), sizeof(header)}));
}

uint64_t chunkCount(uint64_t file_bytes, uint64_t chunk_bytes) {
  return file_bytes / chunk_bytes + (file_bytes % chunk_bytes > 0 ? 1 : 0);
}

}  // namespace

bool SceneSums::isSound(uint64_t chunk, ByteSpan bytes) const {
  return bytes.size() == bytesOf(chunk) && xxh64(bytes) == sums[chunk];
}

Result<SceneSums> sumsOf(const std::filesystem::path& scene, uint64_t chunk_bytes) {
  if (!isChunkSize(chunk_bytes))
    return Error{ErrorCode::kInvalidArgument,
                 "a chunk has 4 KiB to 16 MiB, and a power of two of them: not " + std::to_string(chunk_bytes)};
  const auto file = MappedFile::open(scene);
  if (!file) return file.error();
  const ByteSpan bytes = file->span();
  HeaderStart start;
  std::memcpy(&start, bytes.data(), sizeof(start));
  SceneSums sums{chunk_bytes, bytes.size(), start.scene_id, {}};
  sums.sums.reserve(chunkCount(sums.file_bytes, chunk_bytes));
  for (uint64_t chunk = 0; chunk < chunkCount(sums.file_bytes, chunk_bytes); ++chunk)
    sums.sums.push_back(xxh64(bytes.subspan(sums.begin(chunk), sums.bytesOf(chunk))));
  return sums;
}

Bytes encode(const SceneSums& sums) {
  SumsHeader header;
  header.chunk_bytes = static_cast<uint32_t>(sums.chunk_bytes);
  header.file_bytes = sums.file_bytes;
  header.scene_id = sums.scene_id;
  header.checksum = checksumOf(header, sums.sums);
  Bytes out;
  ByteWriter writer(out);
  writer.put(header);
  writer.putBytes(bytesOf(sums.sums));
  return out;
}

Result<SceneSums> decodeSums(ByteSpan bytes, const std::string& name) {
  const auto refused = [&](const std::string& what) {
    return Error{ErrorCode::kMalformed,
                 name + ": " + what + "; make it anew beside the scene, by `foreland sums SCENE.fls`"};
  };
  ByteReader reader(bytes);
  const auto header = reader.get<SumsHeader>();
  if (!reader.ok() || header.magic != SumsHeader{}.magic) return refused("it holds no checksums of a scene");
  if (header.version != SumsHeader{}.version)
    return Error{ErrorCode::kUnsupported, name + ": its version is " + std::to_string(header.version) +
                                              ", which this program cannot read; make it with the same version"};
  if (!isChunkSize(header.chunk_bytes) ||
      reader.remaining() != chunkCount(header.file_bytes, header.chunk_bytes) * sizeof(uint64_t))
    return refused("its sizes contradict each other, or it is cut short");
  SceneSums sums{header.chunk_bytes, header.file_bytes, header.scene_id, {}};
  sums.sums.resize(reader.remaining() / sizeof(uint64_t));
  const ByteSpan rest = reader.getBytes(reader.remaining());
  std::copy(rest.begin(), rest.end(), reinterpret_cast<uint8_t*>(sums.sums.data()));
  if (checksumOf(header, sums.sums) != header.checksum) return refused("it is damaged");
  return sums;
}

}  // namespace foreland::terrain
