#include "terrain/render/embree_scene.h"

#include <embree3/rtcore.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <limits>
#include <string>
#include <vector>

#include "base/check.h"

namespace foreland::terrain {

namespace {

struct Device {
  explicit Device(int64_t limit_bytes) : handle(rtcNewDevice(nullptr)), max_bytes(limit_bytes) {
    CHECK_TRUE(handle != nullptr);  // a processor without SSE2, which this is not built for
    rtcSetDeviceMemoryMonitorFunction(
        handle, [](void* self, ssize_t change, bool) { return static_cast<Device*>(self)->count(change); }, this);
  }
  ~Device() { rtcReleaseDevice(handle); }
  // Whether Embree may have more. It does not allocate what is refused, nor report it as freed.
  bool count(int64_t change) {
    if (bytes.fetch_add(change) + change <= max_bytes || change < 0) return true;
    bytes.fetch_sub(change);
    return false;
  }
  Device(const Device&) = delete;
  Device& operator=(const Device&) = delete;

  RTCDevice handle;
  const int64_t max_bytes;
  std::atomic<int64_t> bytes{0};
};

}  // namespace

struct EmbreeScene::Impl {
  explicit Impl(std::shared_ptr<Device> shared) : device(std::move(shared)), scene(rtcNewScene(device->handle)) {
    // Robust: no ray passes between two triangles that share an edge. Compact: a tenth less memory.
    if (scene == nullptr)
      keepFailure();
    else
      rtcSetSceneFlags(scene, static_cast<RTCSceneFlags>(RTC_SCENE_FLAG_ROBUST | RTC_SCENE_FLAG_COMPACT));
  }
  ~Impl() {
    if (scene != nullptr) rtcReleaseScene(scene);
  }
  Impl(const Impl&) = delete;
  Impl& operator=(const Impl&) = delete;

  // `is_filled` says whether Embree had memory for all of its buffers.
  void attach(RTCGeometry geometry, bool is_filled) {
    if (scene == nullptr || geometry == nullptr || !is_filled) {
      keepFailure();
      if (geometry != nullptr) rtcReleaseGeometry(geometry);
      return;
    }
    rtcCommitGeometry(geometry);
    is_quads.push_back(false);
    rtcAttachGeometryByID(scene, geometry, static_cast<unsigned>(is_quads.size() - 1));
    rtcReleaseGeometry(geometry);
  }

  // Embree forgets its errors when asked for them, by whichever scene.
  void keepFailure() {
    const RTCError error = rtcGetDeviceError(device->handle);
    if (failure == RTC_ERROR_NONE) failure = error == RTC_ERROR_NONE ? RTC_ERROR_OUT_OF_MEMORY : error;
  }

  std::shared_ptr<Device> device;
  RTCScene scene;
  std::vector<bool> is_quads;         // by geometry
  RTCError failure = RTC_ERROR_NONE;  // to take what was added
};

EmbreeScene::EmbreeScene(int64_t max_bytes)
    : EmbreeScene(std::make_unique<Impl>(std::make_shared<Device>(max_bytes))) {}
EmbreeScene EmbreeScene::partOf(const EmbreeScene& whole) {
  return EmbreeScene(std::make_unique<Impl>(whole.impl_->device));
}
EmbreeScene::EmbreeScene(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
EmbreeScene::~EmbreeScene() = default;
EmbreeScene::EmbreeScene(EmbreeScene&&) noexcept = default;
EmbreeScene& EmbreeScene::operator=(EmbreeScene&&) noexcept = default;

void EmbreeScene::addQuads(size_t vertices, size_t quads, const FillQuads& fill) {
  RTCGeometry geometry = rtcNewGeometry(impl_->device->handle, RTC_GEOMETRY_TYPE_QUAD);
  void* at =
      rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, sizeof(glm::vec3), vertices);
  void* corners =
      rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT4, sizeof(glm::uvec4), quads);
  const bool is_filled = (at != nullptr || vertices == 0) && (corners != nullptr || quads == 0);
  if (is_filled) fill({static_cast<glm::vec3*>(at), vertices}, {static_cast<glm::uvec4*>(corners), quads});
  impl_->attach(geometry, is_filled);
  if (impl_->failure == RTC_ERROR_NONE) impl_->is_quads.back() = true;
}

void EmbreeScene::addTriangles(std::span<const glm::vec3> vertices, std::span<const uint32_t> indices) {
  RTCGeometry geometry = rtcNewGeometry(impl_->device->handle, RTC_GEOMETRY_TYPE_TRIANGLE);
  void* at = rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, sizeof(glm::vec3),
                                     vertices.size());
  void* corners = rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, 3 * sizeof(uint32_t),
                                          indices.size() / 3);
  const bool is_filled = (at != nullptr || vertices.empty()) && (corners != nullptr || indices.empty());
  if (is_filled) {
    std::copy(vertices.begin(), vertices.end(), static_cast<glm::vec3*>(at));
    std::copy(indices.begin(), indices.end(), static_cast<uint32_t*>(corners));
  }
  impl_->attach(geometry, is_filled);
}

void EmbreeScene::addInstance(const EmbreeScene& part, const glm::mat3& linear, const glm::vec3& offset) {
  CHECK_TRUE(part.impl_->device == impl_->device && part.impl_->failure == RTC_ERROR_NONE);
  RTCGeometry geometry = rtcNewGeometry(impl_->device->handle, RTC_GEOMETRY_TYPE_INSTANCE);
  rtcSetGeometryInstancedScene(geometry, part.impl_->scene);
  rtcSetGeometryTimeStepCount(geometry, 1);
  const std::array<glm::vec3, 4> columns{linear[0], linear[1], linear[2], offset};
  rtcSetGeometryTransform(geometry, 0, RTC_FORMAT_FLOAT3X4_COLUMN_MAJOR, columns.data());
  impl_->attach(geometry, true);
}

Status EmbreeScene::commit() {
  if (impl_->failure == RTC_ERROR_NONE) rtcCommitScene(impl_->scene);
  const RTCError error = impl_->failure == RTC_ERROR_NONE ? rtcGetDeviceError(impl_->device->handle) : impl_->failure;
  if (error == RTC_ERROR_NONE) return {};
  if (error == RTC_ERROR_OUT_OF_MEMORY)
    return Error{ErrorCode::kLimit, "ray casting: the scene at full resolution does not fit into memory"};
  return Error{ErrorCode::kUnsupported,
               "ray casting: Embree refuses the scene with its error " + std::to_string(error)};
}

std::optional<EmbreeHit> EmbreeScene::cast(const glm::vec3& origin, const glm::vec3& direction, float nearest,
                                           float farthest) const {
  RTCRayHit r{};
  r.ray.org_x = origin.x, r.ray.org_y = origin.y, r.ray.org_z = origin.z;
  r.ray.dir_x = direction.x, r.ray.dir_y = direction.y, r.ray.dir_z = direction.z;
  r.ray.tnear = nearest, r.ray.tfar = farthest;
  r.ray.mask = 0xffffffffu;
  r.hit.geomID = r.hit.instID[0] = RTC_INVALID_GEOMETRY_ID;
  RTCIntersectContext context;
  rtcInitIntersectContext(&context);
  rtcIntersect1(impl_->scene, &context, &r);
  if (r.hit.geomID == RTC_INVALID_GEOMETRY_ID) return std::nullopt;
  EmbreeHit hit{r.hit.geomID, r.hit.instID[0], r.hit.primID, r.hit.u, r.hit.v};
  hit.is_second = hit.instance == EmbreeHit::kNone && impl_->is_quads[hit.geometry] && hit.u + hit.v > 1;
  if (hit.is_second) hit.u = 1 - hit.u, hit.v = 1 - hit.v;
  return hit;
}

uint64_t EmbreeScene::bytes() const { return static_cast<uint64_t>(std::max<int64_t>(0, impl_->device->bytes)); }

}  // namespace foreland::terrain
