// What control.cpp and welcome.cpp share of writing and reading FlatBuffers. Not for anyone else: other code sees the
// structs of control.h.
#pragma once

#include <cstring>
#include <glm/vec2.hpp>
#include <string>

#include "base/bytes.h"
#include "base/printable.h"
#include "base/result.h"
#include "message_generated.h"
#include "proto/message/control.h"
#include "proto/message/kind.h"

namespace foreland::proto {

using Builder = flatbuffers::FlatBufferBuilder;

inline constexpr size_t kMaxTextBytes = 64 << 10;  // of a title, or of why the server refuses

inline fb::Vec2 bufferOf(const glm::dvec2& v) { return {v.x, v.y}; }
inline glm::dvec2 vectorOf(const fb::Vec2& v) { return {v.x(), v.y()}; }

inline std::string text(const flatbuffers::String* s, size_t limit) {
  return s ? std::string(cutText(s->str(), limit)) : std::string();
}

// FlatBuffers' verifier does not see to the alignment of a vector's structs, so they are read bytewise.
template <class T>
T structAt(const flatbuffers::Vector<const T*>& in, size_t i) {
  T out;
  std::memcpy(static_cast<void*>(&out), in.Data() + i * sizeof(T), sizeof(T));
  return out;
}

inline Bytes finish(Builder& b, fb::Body type, flatbuffers::Offset<void> body) {
  b.Finish(fb::CreateControl(b, type, body));
  Bytes out;
  out.reserve(b.GetSize() + 1);
  out.push_back(static_cast<uint8_t>(MessageKind::kControl));
  out.insert(out.end(), b.GetBufferPointer(), b.GetBufferPointer() + b.GetSize());
  return out;
}

// What messages say. An Error if that is not sound.
Result<Welcome> readWelcome(const fb::Welcome& m);
Result<SightRequest> readSightRequest(const fb::SightRequest& m);
Result<ViewshedRequest> readViewshedRequest(const fb::ViewshedRequest& m);
Result<SightReply> readSightReply(const fb::SightReply& m);
Result<ViewshedReply> readViewshedReply(const fb::ViewshedReply& m);

}  // namespace foreland::proto
