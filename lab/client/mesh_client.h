// A client at the end of a wire without a link that makes every keyframe's mesh in two ways: by change, and anew. For
// `foreland bench client`. One owner.
#pragma once

#include <cstdint>

#include "client/drawn_mesh.h"
#include "client/replica.h"
#include "oracle/reference/whole_mesh.h"
#include "proto/message/message.h"

namespace foreland::lab {

class MeshClient {
 public:
  explicit MeshClient(const proto::Welcome& welcome) : replica_(welcome) {}

  // Reads a message; false if it is no keyframe.
  bool read(ByteSpan bytes) {
    auto message = proto::decodeServerMessage(bytes, headers_);
    auto* keyframe = message ? std::get_if<proto::KeyframeMessage>(&*message) : nullptr;
    if (keyframe != nullptr) keyframe_ = std::move(*keyframe);
    return keyframe != nullptr;
  }
  // Decodes the keyframe that was read; false if it is malformed.
  bool decode() { return replica_.apply(keyframe_.header, keyframe_.delta).ok(); }
  // Brings the mesh to that keyframe.
  void patch() {
    replica_.makePatch(patch_);
    drawn_.apply(patch_);
  }
  // What has changed since the last call, as the page uploads it.
  void collect() {
    uploads_ = upload_bytes_ = 0;
    for (client::PatchedMesh* part : {&drawn_.terrain(), &drawn_.objects()}) {
      part->collectChanges(client::kUploadGap, ranges_);
      const client::BlendMesh& mesh = part == &drawn_.terrain() ? drawn_.mesh() : drawn_.mesh().objects;
      upload_bytes_ += part->isAllChanged() ? client::bytesOf(mesh) : ranges_.bytes();
      uploads_ += part->isAllChanged() ? 1 : ranges_.count();
      part->clearChanges();
    }
  }
  // The same mesh from nothing; how many triangles it has.
  size_t buildAnew() const { return oracle::wholeMesh(replica_).drawnTriangles(); }

  const client::Replica& replica() const { return replica_; }
  size_t triangles() const { return drawn_.mesh().drawnTriangles(); }
  size_t wholeBytes() const { return client::bytesOf(drawn_.mesh()) + client::bytesOf(drawn_.mesh().objects); }
  size_t uploadBytes() const { return upload_bytes_; }
  size_t uploads() const { return uploads_; }

 private:
  client::Replica replica_;
  proto::KeyframeMemory headers_;
  proto::KeyframeMessage keyframe_;
  client::MeshPatch patch_;
  client::DrawnMesh drawn_;
  client::ChangedRanges ranges_;
  size_t upload_bytes_ = 0, uploads_ = 0;
};

}  // namespace foreland::lab
