// Embree's handles on the server's side, freed by who owns them, and how much memory Embree takes. Files that cast rays
// or ask user geometry include it, and keep it and Embree's types to themselves. terrain/render has its own, for it
// shares no code with what answers the server's questions.
#pragma once

#include <embree3/rtcore.h>

#include <algorithm>
#include <atomic>
#include <cstdint>
#include <glm/vec3.hpp>
#include <limits>
#include <memory>
#include <type_traits>

namespace foreland::server {

struct ReleaseScene {
  void operator()(RTCScene scene) const { rtcReleaseScene(scene); }
};
// Must not outlive its device.
using EmbreeScene = std::unique_ptr<std::remove_pointer_t<RTCScene>, ReleaseScene>;

class EmbreeDevice {
 public:
  static constexpr uint64_t kUnlimited = std::numeric_limits<int64_t>::max();
  // kOne: the other processors are for those who fly.
  enum class Threads : uint8_t { kOne, kAll };
  // Embree does not allocate what would be more than `max_bytes`. handle() is null where Embree cannot be used.
  explicit EmbreeDevice(Threads threads, uint64_t max_bytes = kUnlimited)
      : max_bytes_(static_cast<int64_t>(std::min(max_bytes, kUnlimited))),
        device_(rtcNewDevice(threads == Threads::kOne ? "threads=1" : nullptr)) {
    if (device_ != nullptr) rtcSetDeviceMemoryMonitorFunction(device_, count, this);
  }
  ~EmbreeDevice() {
    if (device_ != nullptr) rtcReleaseDevice(device_);
  }
  EmbreeDevice(const EmbreeDevice&) = delete;
  EmbreeDevice& operator=(const EmbreeDevice&) = delete;

  RTCDevice handle() const { return device_; }
  // Null if there is no memory for one.
  EmbreeScene newScene() const { return EmbreeScene(rtcNewScene(device_)); }
  // Since the last call: Embree forgets its errors when asked for them.
  RTCError error() const { return rtcGetDeviceError(device_); }
  uint64_t bytes() const { return static_cast<uint64_t>(std::max<int64_t>(0, bytes_)); }

 private:
  // Whether Embree may have more. It does not report as freed what it was refused.
  static bool count(void* self, ssize_t change, bool) {
    auto& device = *static_cast<EmbreeDevice*>(self);
    if (device.bytes_.fetch_add(change) + change <= device.max_bytes_ || change < 0) return true;
    device.bytes_.fetch_sub(change);
    return false;
  }

  const int64_t max_bytes_;
  std::atomic<int64_t> bytes_{0};
  RTCDevice device_;
};

// From `from` to `from + way`; shares of that.
inline RTCRay embreeRay(const glm::vec3& from, const glm::vec3& way) {
  RTCRay ray{};
  ray.org_x = from.x, ray.org_y = from.y, ray.org_z = from.z;
  ray.dir_x = way.x, ray.dir_y = way.y, ray.dir_z = way.z;
  ray.tnear = 0, ray.tfar = 1;
  ray.mask = ~0u;
  return ray;
}

}  // namespace foreland::server
