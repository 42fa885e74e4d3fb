#include "terrain/model/gltf/container.h"

#include <algorithm>
#include <optional>
#include <string>
#include <string_view>
#include <utility>

#include "base/utf8.h"

namespace foreland::terrain {

namespace {

constexpr size_t kContainerHeaderBytes = 12, kChunkHeaderBytes = 8;
constexpr uint32_t kMagic = 0x46546c67, kJson = 0x4e4f534a, kBinary = 0x004e4942;  // "glTF", "JSON", "BIN"

Error malformedContainer(std::string what) { return {ErrorCode::kMalformed, std::move(what)}; }

uint32_t wordAt(ByteSpan bytes, size_t at) {
  uint32_t word = 0;
  for (size_t i = 0; i < 4; ++i) word |= uint32_t{bytes[at + i]} << (8 * i);
  return word;
}

// Chunks should end at a multiple of four, but some programs do not pad them. Where the one behind a chunk of `size`
// bytes begins.
uint64_t endOfChunk(ByteSpan content, uint64_t size) {
  const uint64_t padded = std::min<uint64_t>((size + 3) / 4 * 4, content.size());
  const auto isChunkAt = [&](uint64_t at) {
    return content.size() - at >= kChunkHeaderBytes && wordAt(content, at + 4) == kBinary;
  };
  return !isChunkAt(padded) && isChunkAt(size) ? size : padded;
}

struct Chunk {
  uint32_t kind = 0;
  ByteSpan content;
};

// The first chunk of `bytes`, which is cut off them; nothing if none begins there, or if it does not end there.
std::optional<Chunk> takeChunk(ByteSpan& bytes) {
  if (bytes.size() < kChunkHeaderBytes) return std::nullopt;
  const uint64_t size = wordAt(bytes, 0);
  if (size > bytes.size() - kChunkHeaderBytes) return std::nullopt;
  const Chunk chunk{wordAt(bytes, 4), bytes.subspan(kChunkHeaderBytes, size)};
  bytes = bytes.subspan(kChunkHeaderBytes + endOfChunk(bytes.subspan(kChunkHeaderBytes), size));
  return chunk;
}

bool begins(ByteSpan bytes, uint32_t kind) { return bytes.size() >= kChunkHeaderBytes && wordAt(bytes, 4) == kind; }

// The first chunk of JSON and the first buffer; what else there is, and a length that is not the file's, is noted.
Status splitBinary(ByteSpan bytes, ByteSpan& text, GltfContainer& made) {
  if (bytes.size() < kContainerHeaderBytes) return malformedContainer("is cut short; copy or export it again");
  if (wordAt(bytes, 4) != 2)
    return Error{ErrorCode::kUnsupported,
                 "is binary glTF of version " + std::to_string(wordAt(bytes, 4)) + "; export it as glTF 2.0"};
  const uint64_t promised = wordAt(bytes, 8);
  if (promised != bytes.size())
    made.notes.push_back("says that it has " + std::to_string(promised) + " bytes, but has " +
                         std::to_string(bytes.size()));
  ByteSpan rest = bytes.subspan(kContainerHeaderBytes);
  bool has_text = false, has_buffer = false;
  size_t others = 0;
  while (const auto chunk = takeChunk(rest)) {
    if (chunk->kind == kJson && !std::exchange(has_text, true))
      text = chunk->content;
    else if (chunk->kind == kBinary && has_text && !std::exchange(has_buffer, true))
      made.buffer = chunk->content;
    else
      ++others;
  }
  if (!has_text || (!has_buffer && begins(rest, kBinary)))
    return malformedContainer("is cut short; copy or export it again");
  if (others > 0) made.notes.push_back("chunks of other kinds left out: " + std::to_string(others));
  if (std::any_of(rest.begin(), rest.end(), [](uint8_t byte) { return byte != 0; }))
    made.notes.push_back("bytes behind the last chunk left out: " + std::to_string(rest.size()));
  return {};
}

}  // namespace

Result<GltfContainer> parseGltfContainer(ByteSpan bytes) {
  GltfContainer made;
  ByteSpan text = bytes;
  if (bytes.size() >= 4 && wordAt(bytes, 0) == kMagic)
    if (Status status = splitBinary(bytes, text, made); !status.ok()) return status.error();
  std::string storage;
  const auto utf8 = asUtf8({reinterpret_cast<const char*>(text.data()), text.size()}, storage);
  if (!utf8.ok()) return utf8.error();
  // Blanks should pad the text; some programs write zeros.
  const std::string_view unpadded = utf8->substr(0, utf8->find_last_not_of('\0') + 1);
  constexpr auto kNoCallback = nullptr;
  constexpr bool kThrows = false;
  made.json = nlohmann::json::parse(unpadded.begin(), unpadded.end(), kNoCallback, kThrows);
  if (!made.json.is_object()) return malformedContainer("is no glTF file: its JSON is broken; export the model again");
  return made;
}

}  // namespace foreland::terrain
