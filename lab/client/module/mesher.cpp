// A client that makes meshes and draws nothing, as a WebAssembly module for `foreland bench client` (make_meshes.mjs):
// the stream of a flight is written to its memory at once, then messages are read and worked on one by one. One stream
// at a time.
#include <memory>

#include "lab/client/mesh_client.h"

#define FORELAND_EXPORT(name) extern "C" __attribute__((export_name(#name)))

namespace foreland::lab {
namespace {

struct Mesher {
  Bytes stream;
  std::unique_ptr<MeshClient> client;
};

Mesher& mesher() {
  static Mesher instance;
  return instance;
}

}  // namespace

// Room for the stream's bytes.
FORELAND_EXPORT(mesher_buffer) uint8_t* buffer(uint32_t size) {
  mesher().stream.resize(size);
  return mesher().stream.data();
}

// Begins with the welcome of `size` bytes at `begin`; 1 if it is one, else 0.
FORELAND_EXPORT(mesher_welcome) uint32_t welcome(uint32_t begin, uint32_t size) {
  proto::KeyframeMemory none;
  auto message = proto::decodeServerMessage(ByteSpan(mesher().stream).subspan(begin, size), none);
  const auto* welcome = message ? std::get_if<proto::Welcome>(&*message) : nullptr;
  if (welcome) mesher().client = std::make_unique<MeshClient>(*welcome);
  return welcome ? 1 : 0;
}

// Reads the keyframe of `size` bytes at `begin`; decodes it. 1 if that succeeds, else 0.
FORELAND_EXPORT(mesher_read) uint32_t read(uint32_t begin, uint32_t size) {
  return mesher().client->read(ByteSpan(mesher().stream).subspan(begin, size)) ? 1 : 0;
}
FORELAND_EXPORT(mesher_decode) uint32_t decode() { return mesher().client->decode() ? 1 : 0; }

// Brings the mesh to the keyframe that was decoded; makes it anew. Tell how many triangles it has.
FORELAND_EXPORT(mesher_patch) uint32_t patch() {
  mesher().client->patch();
  return static_cast<uint32_t>(mesher().client->triangles());
}
FORELAND_EXPORT(mesher_build) uint32_t build() { return static_cast<uint32_t>(mesher().client->buildAnew()); }

}  // namespace foreland::lab
