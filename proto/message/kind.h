// The kind of a message, which its first byte states. For the files of this folder; others include message.h. Pure; any
// thread; portable to WebAssembly.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>

#include "base/bytes.h"
#include "base/result.h"

namespace foreland::proto {

// In the low three bits of the first byte. The other bits of the byte belong to the message where it is written as bits
// (steps, which are relative to an earlier message), and are zero elsewhere.
enum class MessageKind : uint8_t {
  kNone = 0,  // no message has it
  kControl = 1,
  kPose = 2,
  kKeyframe = 3,
  kResume = 4,
  kPoseStep = 5,
  kKeyframeStep = 6,
  kTile = 7
};

inline constexpr int kKindBits = 3;

// The message is not empty.
inline MessageKind kindOf(ByteSpan bytes) {
  const auto kind = static_cast<MessageKind>(bytes[0] & ((1 << kKindBits) - 1));
  if (kind == MessageKind::kPoseStep || kind == MessageKind::kKeyframeStep) return kind;
  return bytes[0] < (1 << kKindBits) ? kind : MessageKind::kNone;
}

// Takes no string, which each of its many callers would make.
inline Error malformed(std::string_view what) { return {ErrorCode::kMalformed, std::string("message: ").append(what)}; }

}  // namespace foreland::proto
