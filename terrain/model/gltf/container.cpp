#include "terrain/model/gltf/container.h"

#include <algorithm>
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

// The content of the first chunk of `bytes`, which is cut off them, if it is of that kind; else nothing.
Result<ByteSpan> takeChunk(ByteSpan& bytes, uint32_t kind) {
  if (bytes.size() < kChunkHeaderBytes || wordAt(bytes, 4) != kind) return ByteSpan();
  const uint64_t size = wordAt(bytes, 0);
  if (size > bytes.size() - kChunkHeaderBytes) return malformedContainer("is cut short; copy or export it again");
  const ByteSpan chunk = bytes.subspan(kChunkHeaderBytes, size);
  bytes = bytes.subspan(kChunkHeaderBytes + endOfChunk(bytes.subspan(kChunkHeaderBytes), size));
  return chunk;
}

Status splitBinary(ByteSpan bytes, ByteSpan& text, ByteSpan& buffer) {
  if (bytes.size() < kContainerHeaderBytes) return malformedContainer("is cut short; copy or export it again");
  if (wordAt(bytes, 4) != 2)
    return Error{ErrorCode::kUnsupported,
                 "is binary glTF of version " + std::to_string(wordAt(bytes, 4)) + "; export it as glTF 2.0"};
  const uint64_t size = wordAt(bytes, 8);
  if (size > bytes.size() || size < kContainerHeaderBytes)
    return malformedContainer("is cut short; copy or export it again");
  ByteSpan rest = bytes.subspan(kContainerHeaderBytes, size - kContainerHeaderBytes);
  const auto json = takeChunk(rest, kJson);
  if (!json.ok()) return json.error();
  const auto binary = takeChunk(rest, kBinary);
  if (!binary.ok()) return binary.error();
  text = *json, buffer = *binary;
  return {};
}

}  // namespace

Result<GltfContainer> parseGltfContainer(ByteSpan bytes) {
  GltfContainer made;
  ByteSpan text = bytes;
  if (bytes.size() >= 4 && wordAt(bytes, 0) == kMagic)
    if (Status status = splitBinary(bytes, text, made.buffer); !status.ok()) return status.error();
  std::string storage;
  const auto utf8 = asUtf8({reinterpret_cast<const char*>(text.data()), text.size()}, storage);
  if (!utf8.ok()) return utf8.error();
  constexpr auto kNoCallback = nullptr;
  constexpr bool kThrows = false;
  made.json = nlohmann::json::parse(utf8->begin(), utf8->end(), kNoCallback, kThrows);
  if (!made.json.is_object()) return malformedContainer("is no glTF file: its JSON is broken; export the model again");
  return made;
}

}  // namespace foreland::terrain
