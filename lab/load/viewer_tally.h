// What a viewer got of a load, told where it can be told in virtual and in real time alike: at the viewer, of the
// keyframes for times of the measured window. So both count the same keyframes, whenever they arrive. Value type.
#pragma once

#include <cstdint>
#include <vector>

#include "lab/load/light_viewer.h"

namespace foreland::lab {

struct ViewerTally {
  uint64_t keyframes = 0;
  uint64_t late = 0;                // after the time from which they were to be shown
  uint64_t bytes = 0;               // of their messages
  std::vector<double> lateness_ms;  // of each, in the order of arrival; negative is early

  // Notes what arrived, `size` bytes, if it is a keyframe for a time in [begin, end) of the viewer's clock.
  void add(const LightViewer::Received& received, size_t size, Time begin, Time end) {
    if (!received.is_keyframe || received.time < begin || received.time >= end) return;
    ++keyframes;
    late += received.lateness > Duration{};
    bytes += size;
    lateness_ms.push_back(received.lateness.toMilliseconds());
  }
};

}  // namespace foreland::lab
