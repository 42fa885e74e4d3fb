#include "proto/message/message.h"

#include <utility>

#include "proto/message/kind.h"

namespace foreland::proto {

namespace {

// The same value in a variant of more types.
template <class Message, class... Types>
Result<Message> widen(Result<std::variant<Types...>> control) {
  if (!control) return control.error();
  return std::visit([](auto& value) { return Message(std::move(value)); }, *control);
}
template <class Message, class Value>
Result<Message> widen(Result<Value> value) {
  if (!value) return value.error();
  return Message(std::move(value).value());
}

}  // namespace

Result<ClientMessage> decodeClientMessage(ByteSpan bytes, PoseMemory& memory) {
  if (bytes.empty()) return malformed("empty");
  if (bytes.size() > kMaxClientMessageBytes) return malformed("larger than 16 MiB");
  switch (kindOf(bytes)) {
    case MessageKind::kPose:
    case MessageKind::kPoseStep:
      return widen<ClientMessage>(decodePose(bytes, memory));
    case MessageKind::kResume:
      return widen<ClientMessage>(decodeResume(bytes));
    case MessageKind::kControl:
      return widen<ClientMessage>(decodeClientControl(bytes));
    default:
      return malformed("not a message of this protocol");
  }
}

Result<ServerMessage> decodeServerMessage(ByteSpan bytes, KeyframeMemory& memory) {
  if (bytes.empty()) return malformed("empty");
  if (bytes.size() > kMaxServerMessageBytes) return malformed("larger than 64 MiB");
  switch (kindOf(bytes)) {
    case MessageKind::kKeyframe:
    case MessageKind::kKeyframeStep:
      return widen<ServerMessage>(decodeKeyframe(bytes, memory));
    case MessageKind::kControl:
      return widen<ServerMessage>(decodeServerControl(bytes));
    case MessageKind::kTile:
      return isTileStatement(bytes) ? widen<ServerMessage>(decodeTileStatement(bytes))
                                    : widen<ServerMessage>(decodeTile(bytes));
    default:
      return malformed("not a message of this protocol");
  }
}

Result<ClientMessage> decodeClientMessage(ByteSpan bytes) {
  PoseMemory none;
  return decodeClientMessage(bytes, none);
}

Result<ServerMessage> decodeServerMessage(ByteSpan bytes) {
  KeyframeMemory none;
  return decodeServerMessage(bytes, none);
}

}  // namespace foreland::proto
