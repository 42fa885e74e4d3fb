// What a host of the C interface has chosen, as requests to the server. Pure; any thread.
#pragma once

#include "base/result.h"
#include "client/c/foreland.h"
#include "client/c/session_loop.h"

namespace foreland::client {

struct Choice {
  ForelandOptions options{};  // 0: the default; what it points to is not looked at
  ForelandLens lens{};        // of size 0: the default
  bool has_path = false;      // one is announced
};

// `options` with what is not 0 in `changes`.
void change(ForelandOptions& options, const ForelandOptions& changes);

// An Error if something is out of range.
Result<proto::ViewRequest> requestOf(const Choice& choice);
Result<Blend> blendOf(const ForelandOptions& options);

// Whether a server takes it; the Error is what it would say.
template <class Message>
Status isTaken(const Message& message) {
  const auto decoded = proto::decodeClientControl(proto::encode(message));
  return decoded.ok() ? Status{} : Status{Error{ErrorCode::kInvalidArgument, decoded.error().message}};
}

}  // namespace foreland::client
