// A client that does nothing but decode, as a WebAssembly module for `foreland bench wire` (decode_stream.mjs): the
// stream of a flight is written to its memory at once, then messages are read and applied one by one. One stream at a
// time.
#include <optional>

#include "client/replica.h"
#include "lab/wire/digest.h"
#include "proto/message/message.h"

#define FORELAND_EXPORT(name) extern "C" __attribute__((export_name(#name)))

namespace foreland::lab {
namespace {

struct Decoder {
  Bytes stream;
  std::optional<client::Replica> replica;
  proto::KeyframeMemory headers;
  std::optional<proto::ServerMessage> message;
};

Decoder& decoder() {
  static Decoder instance;
  return instance;
}

}  // namespace

// Room for the stream's bytes.
FORELAND_EXPORT(decoder_buffer) uint8_t* buffer(uint32_t size) {
  decoder().stream.resize(size);
  return decoder().stream.data();
}

// Reads the message of `size` bytes from `begin` on. A welcome starts afresh. 1 if there is one, else 0.
FORELAND_EXPORT(decoder_read) uint32_t read(uint32_t begin, uint32_t size) {
  Decoder& d = decoder();
  if (begin > d.stream.size() || size > d.stream.size() - begin) return 0;
  auto message = proto::decodeServerMessage(ByteSpan(d.stream).subspan(begin, size), d.headers);
  if (!message.ok()) return 0;
  d.message = std::move(message).value();
  if (const auto* welcome = std::get_if<proto::Welcome>(&*d.message)) {
    d.replica.emplace(*welcome);
    d.headers = {};
  }
  return 1;
}

// Takes the keyframe that was read last. 1 if it fits, else 0.
FORELAND_EXPORT(decoder_apply) uint32_t apply() {
  Decoder& d = decoder();
  const auto* keyframe = d.message ? std::get_if<proto::KeyframeMessage>(&*d.message) : nullptr;
  return keyframe && d.replica && d.replica->apply(keyframe->header, keyframe->delta).ok() ? 1 : 0;
}

// Of the section held (digest.h).
FORELAND_EXPORT(decoder_digest) uint32_t digest() { return decoder().replica ? digestOf(*decoder().replica) : 0; }

}  // namespace foreland::lab
