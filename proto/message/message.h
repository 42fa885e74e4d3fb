// Any message of a session, by its direction, and from bytes to which of them it is. Its values and their encoders are
// in control.h and compact.h. Pure functions; any thread; portable to WebAssembly.
#pragma once

#include <variant>

#include "proto/message/compact.h"
#include "proto/message/control.h"
#include "proto/message/tile_message.h"

namespace foreland::proto {

inline constexpr size_t kMaxClientMessageBytes = 16u << 20;  // paths are the largest
inline constexpr size_t kMaxServerMessageBytes = 64u << 20;  // a first section is the largest

using ClientMessage = std::variant<ViewRequest, Path, TourRequest, GroundRequest, SceneClock, HeldTiles, SightRequest,
                                   ViewshedRequest, RequestCancel, PoseUpdate, Resume>;
using ServerMessage = std::variant<Welcome, TourReply, GroundReply, Refusal, SightReply, ViewshedReply, KeyframeMessage,
                                   TileMessage, TileStatement>;

// Any bytes end in a valid value or in an Error; after an Error neither memory nor connection is of use any more.
Result<ClientMessage> decodeClientMessage(ByteSpan bytes, PoseMemory& memory);
Result<ServerMessage> decodeServerMessage(ByteSpan bytes, KeyframeMemory& memory);
// On a connection on which no pose, or keyframe, came before.
Result<ClientMessage> decodeClientMessage(ByteSpan bytes);
Result<ServerMessage> decodeServerMessage(ByteSpan bytes);

}  // namespace foreland::proto
