// Decodes any bytes as a message of either side, and as one connection's stream of messages, each after its size in one
// byte, in which poses and keyframes are delta-coded. The result must be a value or an Error.
#include <algorithm>

#include "base/check.h"
#include "proto/message/message.h"

namespace foreland::proto {
namespace {

// An accepted message can be encoded again, alone or after the same messages as before.
void takeFromClient(ByteSpan bytes, PoseMemory& memory) {
  PoseMemory said = memory, heard = memory;
  const auto m = decodeClientMessage(bytes, memory);
  if (!m) {
    memory = {};
    return;
  }
  if (const auto* pose = std::get_if<PoseUpdate>(&*m)) {
    CHECK_TRUE(decodeClientMessage(encode(*pose)).ok());
    CHECK_TRUE(decodeClientMessage(encode(*pose, said), heard).ok());
  }
}

void takeFromServer(ByteSpan bytes, KeyframeMemory& memory) {
  KeyframeMemory said = memory, heard = memory;
  const auto m = decodeServerMessage(bytes, memory);
  if (!m) {
    memory = {};
    return;
  }
  if (const auto* keyframe = std::get_if<KeyframeMessage>(&*m)) {
    CHECK_LE(keyframe->delta.size(), bytes.size());
    Bytes again;
    encodeHeader(keyframe->header, said, again);
    CHECK_TRUE(decodeServerMessage(again, heard).ok());
  }
}

void takeStream(ByteSpan bytes) {
  PoseMemory poses;
  KeyframeMemory keyframes;
  while (!bytes.empty()) {
    const size_t size = std::min<size_t>(bytes[0], bytes.size() - 1);
    const ByteSpan message = bytes.subspan(1, size);
    takeFromClient(message, poses);
    takeFromServer(message, keyframes);
    bytes = bytes.subspan(1 + size);
  }
}

}  // namespace
}  // namespace foreland::proto

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  using namespace foreland;
  proto::PoseMemory poses;
  proto::KeyframeMemory keyframes;
  proto::takeFromClient({data, size}, poses);
  proto::takeFromServer({data, size}, keyframes);
  proto::takeStream({data, size});
  return 0;
}
