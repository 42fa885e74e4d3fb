// What the module's exports share: the buffer for what comes in, and values as records. One thread.
#pragma once

#include <cmath>
#include <cstdint>

#include "base/bytes.h"
#include "base/time.h"
#include "client/wasm/records.h"
#include "proto/space/pose.h"

#define FORELAND_EXPORT(name) extern "C" __attribute__((export_name(#name)))

namespace foreland::client {

// What the page wrote for the next call.
Bytes& incoming();

inline Time timeOf(double ms) { return {static_cast<int64_t>(std::llround(ms * 1000))}; }
inline double millisecondsOf(Time time) { return static_cast<double>(time.us) / 1000; }

template <class T>
Address addressOf(const T* data) {
  return static_cast<Address>(reinterpret_cast<uintptr_t>(data));
}

inline PoseRecord recordOf(const proto::Pose& pose) {
  const auto& q = pose.orientation;
  return {.eye = {pose.eye.x, pose.eye.y, pose.eye.z}, .orientation = {q.x, q.y, q.z, q.w}};
}

}  // namespace foreland::client
