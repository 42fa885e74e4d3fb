// The server's end of a stream of sections to one viewer: adapts to a view and writes the keyframe that takes the
// viewer's section there. The viewer's replica does the same steps on what it reads. One owner (a session); no
// allocation but the message once grown to the session's size.
#pragma once

#include <optional>

#include "proto/codec/object_stream.h"
#include "proto/codec/section_codec.h"
#include "proto/message/message.h"
#include "proto/refine/adapter.h"
#include "server/section/hierarchy.h"

namespace foreland::server {

// What a worker brings; one per worker, reused.
struct SendScratch {
  proto::AdaptScratch adapt;
  proto::CutDelta delta, object_delta;
  proto::RefineScratch refine;
  proto::Section section;
};

class SectionSender {
 public:
  explicit SectionSender(const Hierarchy& hierarchy);

  // Goes on from closed sections that the viewer presents as those of its keyframe. Nothing has been sent yet.
  void resume(const proto::HeldSections& sections, uint32_t keyframe, Time time, uint32_t fingerprint);

  // Whether the view's section has at most `max_nodes`. Cost: nothing if it cannot be much larger than the last one,
  // else one refinement from scratch.
  [[nodiscard]] bool fits(const proto::View& view, size_t max_nodes, SendScratch& scratch) const;

  // How many nodes of the terrain's section for the view the viewer does not hold, objects' not counted; `max_nodes` if
  // the section has more than that. Cost: one refinement from scratch.
  [[nodiscard]] size_t countAdded(const proto::View& view, size_t max_nodes, SendScratch& scratch) const;

  // Appends the keyframe for `view` to `out` and stands there: at the view as the viewer decodes it
  // (proto::asSentInHeader; tolerance as a float; ball and turn as short floats, no smaller), which is in keyframe().
  // What changed is in scratch.delta, in no order.
  void send(const proto::View& view, Time time, SendScratch& scratch, Bytes& out);

  const proto::KeyframeHeader& keyframe() const { return keyframe_; }  // the last one; index 0 before the first
  const proto::TerrainAdapter& adapter() const { return adapter_; }
  const std::vector<proto::SurfaceAdapter>& objects() const { return objects_; }
  // Of the mesh that the viewer draws, about: two to a node, and the base's.
  double triangles() const;
  // Of the last one: where its bits went, and how many bytes stand before the delta.
  const proto::DeltaBits& bits() const { return bits_; }
  const proto::SurfaceBits& objectBits() const { return object_bits_; }  // of all objects
  size_t headerBytes() const { return header_bytes_; }

 private:
  void sendObjects(const proto::View& view, SendScratch& scratch, proto::RangeEncoder& coder);

  const Hierarchy* hierarchy_;
  proto::TerrainAdapter adapter_;
  proto::DeltaModel model_;  // of all deltas sent
  std::vector<proto::SurfaceAdapter> objects_;
  std::unique_ptr<proto::ObjectStream> stream_;  // none without objects: it is large
  proto::KeyframeHeader keyframe_;
  proto::KeyframeMemory headers_sent_;
  proto::DeltaBits bits_;
  proto::SurfaceBits object_bits_;
  size_t header_bytes_ = 0;
};

}  // namespace foreland::server
