// The server's end of a stream of sections to one viewer: adapts its section to a view and writes the keyframe message
// from which the viewer's replica takes the same steps. One owner (a session). Allocates nothing but the message once
// its buffers have grown to the session's size.
#pragma once

#include <limits>
#include <memory>
#include <vector>

#include "base/check.h"
#include "proto/codec/epoch_stream.h"
#include "proto/codec/object_stream.h"
#include "proto/codec/section_codec.h"
#include "proto/message/message.h"
#include "proto/refine/adapter.h"
#include "server/section/held_pages.h"
#include "server/section/hierarchy.h"

namespace foreland::server {

// Working memory that a worker lends; one per worker, reused.
struct SendScratch {
  proto::AdaptScratch adapt;
  proto::CutDelta delta, object_delta;
  proto::RefineScratch refine;
  proto::Section section;
};

struct SectionSize {
  bool fits;     // has at most as many nodes as asked for
  size_t nodes;  // of terrain and objects; if they do not fit, as many as asked for
  size_t added;  // of these, nodes that the viewer does not know yet; if they do not fit, as many as asked for
};

// Where the server finds out which objects are hidden (server/occlusion); called for each object in turn.
class ObjectVisibility {
 public:
  virtual ~ObjectVisibility() = default;
  // Of an object whose section has so many nodes; 0 while it is hidden.
  virtual bool isObjectHidden(size_t object, size_t nodes) = 0;
};

class SectionSender {
 public:
  explicit SectionSender(const Hierarchy& hierarchy);

  // Starts from `sections`, which the viewer holds from an earlier connection as those of its keyframe `keyframe`. They
  // are closed under parents; nothing has been sent yet. False, and nothing is changed, if what the viewer says it
  // knows cannot be: if a node that is known has a smaller error than any was asked about.
  [[nodiscard]] bool resume(const proto::HeldSections& sections, uint32_t keyframe, Time time, uint32_t fingerprint);

  // Makes deltas tell hidden blocks, as the viewer's welcome says they do. Nothing has been sent yet.
  void signalBlocks() { tells_blocks_ = true; }
  // Remembers what the viewer has been sent as long as the viewer does, which has so many bytes for it. At first
  // proto::kDefaultMemoryBytes.
  void setMemory(uint32_t bytes);

  // The scene time of the keyframes from now on, in a scene with epochs: within them. The next one's may be a step from
  // the last one's (KeyframeHeader::is_scene_step).
  void showAt(Time scene_time, bool is_step = false) {
    scene_time_ = scene_time;
    is_scene_step_ = is_step;
  }

  // Makes the next keyframe start from the empty section, whatever the viewer holds. What it knows it remembers.
  void restart();
  // Whether the next keyframe starts from nothing.
  bool startsFromNothing() const { return is_restarted_ || keyframe_.index == 0; }

  // Whether the section of `view` can be expected to have at most `max_nodes`, because the last keyframe's has less
  // than half as many and its view is similar (a section hardly more than doubles between two keyframes of a moving
  // viewer). It saves a measurement; send() makes sure. Cost: none.
  [[nodiscard]] bool isLikelyToFit(const proto::View& view, size_t max_nodes) const;

  // Measures the sections for `view`, of terrain and objects. Cost: one refinement from scratch, which ends early if
  // there are more than `max_nodes`.
  [[nodiscard]] SectionSize measure(const proto::View& view, size_t max_nodes, SendScratch& scratch) const;

  // The same from a sample, for what steers and promises nothing: about how many nodes the sections for `view` have,
  // and those for `inner`, which differs from it by a smaller region. Cost: some ten thousand nodes of the terrain at
  // most, and refinements of the objects from scratch.
  [[nodiscard]] proto::SampledSize estimate(const proto::View& view, const proto::View& inner,
                                            SendScratch& scratch) const;
  // The same for the last keyframe's own sections. Cost: a sixteenth of the terrain's section, but all of a
  // small one, and the objects.
  [[nodiscard]] proto::SampledSize estimateWithin(const proto::View& inner, SendScratch& scratch) const;

  // Of a scene at a distance: the least tolerance, of those from the view's on, for which send() has all that it reads;
  // else the view's (held_pages.h). Cost: of a scene at a distance one refinement from scratch, else none.
  [[nodiscard]] double toleranceThere(const proto::View& view, SendScratch& scratch);
  // Null unless the scene is at a distance.
  HeldPages* pages() { return pages_.get(); }

  // Adapts the sections to `view` and appends the keyframe message to `out`. False, with nothing appended, if they
  // would have more than `max_nodes` together: the next keyframe then starts from nothing, and must be for a view that
  // was measured.
  //
  // The view of a scene at a distance has a tolerance of toleranceThere(), or a larger one.
  //
  // After success keyframe() holds the view as the viewer decodes it: pose as by proto::asSentInHeader, tolerance as a
  // float, region as short floats that are no smaller. scratch.delta holds the nodes of the terrain that were added and
  // removed, in no order. Cost: one adaptation. Nodes of blocks that `visibility` calls hidden are left out; of none if
  // it is null, which it must be without signalBlocks(). Of objects that `object_visibility` calls hidden the viewer
  // holds no nodes.
  [[nodiscard]] bool send(const proto::View& view, Time time, size_t max_nodes, SendScratch& scratch, Bytes& out,
                          proto::BlockVisibility* visibility = nullptr, ObjectVisibility* object_visibility = nullptr);

  // The same for a caller whose sections may be of any size.
  void send(const proto::View& view, Time time, SendScratch& scratch, Bytes& out,
            proto::BlockVisibility* visibility = nullptr, ObjectVisibility* object_visibility = nullptr) {
    CHECK_TRUE(send(view, time, std::numeric_limits<size_t>::max(), scratch, out, visibility, object_visibility));
  }

  const proto::KeyframeHeader& keyframe() const { return keyframe_; }  // the last one; index 0 before the first
  const proto::TerrainAdapter& adapter() const { return adapter_; }
  // What the last keyframe left out of the terrain; null if it left out nothing.
  const proto::HiddenBlocks* hiddenBlocks() const;
  const std::vector<proto::SurfaceAdapter>& objects() const { return objects_; }
  size_t hiddenObjects() const;                                                        // in the last keyframe
  const std::vector<uint8_t>& hiddenObjectFlags() const { return is_object_hidden_; }  // by object: 1 or 0
  // In the sections of terrain and objects.
  size_t nodeCount() const;
  // About how many triangles the viewer draws: two for each node, and those of the objects' base meshes.
  double triangles() const;
  // Of the last keyframe: where the bits of its delta went, and how many bytes its header has.
  const proto::DeltaBits& bits() const { return bits_; }                 // of the terrain
  const proto::SurfaceBits& objectBits() const { return object_bits_; }  // of all objects
  const proto::EpochBits& epochBits() const { return epoch_bits_; }      // of the ground's motion in time
  size_t headerBytes() const { return header_bytes_; }

 private:
  void restart(proto::Remembered remembered);
  bool measureObjects(const proto::View& view, size_t max_nodes, SendScratch& scratch, SectionSize& size) const;
  double objectNodes(const proto::View& view, SendScratch& scratch) const;
  bool sendObjects(const proto::View& view, size_t max_nodes, ObjectVisibility* visibility, SendScratch& scratch,
                   proto::RangeEncoder& coder);
  void makeObjects();
  void empty(size_t object, proto::CutDelta& delta);

  const Hierarchy* hierarchy_;
  std::unique_ptr<HeldPages> pages_;
  proto::TerrainAdapter adapter_;
  bool tells_blocks_ = false;
  // Adapts over all deltas sent. Null before the first one, for it is large, and many viewers only look on.
  std::unique_ptr<proto::DeltaModel> model_;
  std::vector<proto::SurfaceAdapter> objects_;
  std::vector<uint8_t> is_object_hidden_;        // in the last keyframe
  std::unique_ptr<proto::ObjectStream> stream_;  // null without objects, for it is large
  std::unique_ptr<proto::EpochStream> epochs_;   // null without epochs
  Time scene_time_;
  bool is_scene_step_ = false;
  proto::KeyframeHeader keyframe_;
  proto::KeyframeMemory headers_sent_;
  proto::DeltaBits bits_;
  proto::SurfaceBits object_bits_;
  proto::EpochBits epoch_bits_;
  size_t header_bytes_ = 0;
  proto::Remembered remembered_ = proto::Remembered::kNothing;  // by the next keyframe from nothing
  bool is_restarted_ = false;                                   // and nothing was sent since
};

}  // namespace foreland::server
