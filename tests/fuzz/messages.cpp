// Any bytes as a message, from either side: a value or an Error.
#include "base/check.h"
#include "proto/message.h"

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  using namespace foreland;
  const ByteSpan bytes(data, size);
  if (auto m = proto::decodeClientMessage(bytes)) {
    // What is accepted can be said again.
    if (const auto* pose = std::get_if<proto::PoseUpdate>(&*m))
      CHECK_TRUE(proto::decodeClientMessage(proto::encode(*pose)).ok());
  }
  if (auto m = proto::decodeServerMessage(bytes)) {
    if (const auto* keyframe = std::get_if<proto::KeyframeMessage>(&*m)) CHECK_LE(keyframe->delta.size(), size);
  }
  return 0;
}
