// What keyframes say of the ground's motion in time (section/epochs.h), in scenes that have epochs: the scene time, and
// the offsets of nodes of the section at the epochs that are blended at this time, as far as the client does not know
// them. An offset is sent once, however often the scene time passes its epoch. They follow the terrain and the objects
// in a delta, on the same range coder. Where the blend is not linear they also say whether the scene time has come here
// by a step, in which the ground moves nearly linearly, or by a jump.
//
// An offset is coded as its difference from what its node's offset at the nearest known epoch and the motion of its
// edge's endpoints since then make of it, so ground that does not move costs next to nothing.
//
// It begins with nothing known but the base vertices' offsets, and does so again after a connection has been resumed.
// Both ends forget the same at the same keyframes, once they know a lot. One owner (a session, a replica). Portable to
// WebAssembly.
#pragma once

#include <array>
#include <span>
#include <vector>

#include "proto/codec/symbols.h"
#include "proto/refine/adapter.h"
#include "proto/section/epoch_offsets.h"

namespace foreland::proto {

struct EpochBits {
  double bits = 0;
  uint64_t offsets = 0;
};

class EpochStream {
 public:
  // Blocks of offsets that both ends know at most before they forget those of epochs that are not blended: 4 MB.
  static constexpr size_t kMaxBlocks = 1u << 14;

  // `grid` must outlive it.
  EpochStream(const GridTopology& grid, const Epochs& epochs, std::span<const BaseOffset> base)
      : grid_(&grid), offsets_(grid, epochs, base) {}

  const EpochOffsets& offsets() const { return offsets_; }
  Time sceneTime() const { return scene_time_; }
  // Whether the last keyframe's scene time was reached by a step. Of a linear blend never.
  bool isStep() const { return is_step_; }
  // Nothing is known any more: after the client may have lost what it had.
  void restart();
  // The same at a client that resumes on a new connection; it goes on drawing what it holds.
  void resume();

  // A keyframe, after its terrain: `adapter` has its section, to which `added` came. Cost: O(added) look-ups, and
  // O(section) once other epochs are blended.
  void encode(Time scene_time, bool is_step, const TerrainAdapter& adapter, std::span<const Slot> added,
              const OffsetSource& source, RangeEncoder& coder, EpochBits& bits);
  // False if the bytes were none: this is then of no more use.
  [[nodiscard]] bool decode(const TerrainAdapter& adapter, std::span<const Slot> added, RangeDecoder& coder);

 private:
  struct Model {
    static constexpr size_t kActivities = 10, kBefore = 5;
    std::array<AdaptiveBit, 2> time;
    AdaptiveBit is_step;
    std::array<NumberModel, kActivities * kBefore> offset;
    EscapeModel escape;
  };
  template <class Coder, class ValueOf>
  bool code(Time scene_time, bool is_step, const TerrainAdapter& adapter, std::span<const Slot> added, Coder& coder,
            const ValueOf& valueOf);
  template <class Coder>
  Time codeTime(Coder& coder, Time scene_time);
  template <class Coder, class ValueOf>
  bool codeEpoch(uint32_t epoch, std::span<const Slot> slots, Coder& coder, const ValueOf& valueOf);
  void forget(const EpochWeights& next);
  void restartCoder();

  const GridTopology* grid_;
  EpochOffsets offsets_;
  Model model_;
  Time scene_time_;
  bool is_step_ = false;
  Duration step_;         // of the scene time, from keyframe to keyframe
  bool is_first_ = true;  // nothing was coded since restart()
  EpochWeights blended_;  // at scene_time_
  std::vector<Slot> slots_;
  uint64_t coded_ = 0;  // offsets
};

}  // namespace foreland::proto
