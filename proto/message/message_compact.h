// Inside of the messages: what the two halves of the codec, control messages (message.cpp) and compact ones
// (message_compact.cpp), have in common. For others there is message.h. Pure; any thread; portable to WebAssembly.
#pragma once

#include <string>

#include "proto/message/message.h"

namespace foreland::proto {

// In the low three bits of a message's first byte. Of the steps the rest of the byte belongs to the bits that follow;
// of the others it is zero.
enum class MessageKind : uint8_t {
  kControl = 1,
  kPose = 2,
  kKeyframe = 3,
  kResume = 4,
  kPoseStep = 5,
  kKeyframeStep = 6
};

inline Error malformed(const std::string& what) { return {ErrorCode::kMalformed, "message: " + what}; }

// By the first byte; the message is not empty.
bool isPose(ByteSpan bytes);
bool isKeyframe(ByteSpan bytes);
bool isResume(ByteSpan bytes);

Result<ClientMessage> decodePose(ByteSpan bytes, PoseMemory& memory);
Result<ClientMessage> decodeResume(ByteSpan bytes);
Result<ServerMessage> decodeKeyframe(ByteSpan bytes, KeyframeMemory& memory);

}  // namespace foreland::proto
