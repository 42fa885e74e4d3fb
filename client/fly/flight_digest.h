// What a flight showed, in two numbers, to tell whether a replay shows the same. One owner.
#pragma once

#include <cstdint>

#include "client/viewer.h"

namespace foreland::client {

class FlightDigest {
 public:
  struct Value {
    uint64_t frames = 0;    // shown, meshes included
    uint64_t sections = 0;  // Of the sections of all keyframes, with heights: the same on every machine. Positions are
    uint64_t drawn = 0;     // computed in floating point, so `drawn`, of all frames, is the same for one build only.
    bool operator==(const Value&) const = default;
  };

  // Takes the frame that `viewer` has just shown; nothing if it shows no mesh. Cost: next to none, and for the first
  // frame of a mesh a pass over its bytes and the section's nodes.
  void add(const Viewer& viewer, const FrameView& view);
  const Value& value() const { return value_; }

 private:
  Value value_;
  uint32_t mesh_version_ = 0, keyframe_ = 0;
  uint64_t mesh_ = 0;
};

}  // namespace foreland::client
