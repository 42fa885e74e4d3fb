#include "server/sight/box_tree.h"

#include <array>
#include <cmath>
#include <limits>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "base/check.h"
#include "server/embree/embree_device.h"

namespace foreland::server {

namespace {

// Of the reach: more than the rounding of boxes, of a segment's ends and of its way through the tree.
constexpr double kFloats = 1.0 / (1 << 20);
constexpr uint32_t kBoxesGeometry = 0;  // instance i is geometry 1 + i

struct Boxes {
  BoxTree::BoxOf of;
  double margin;
  glm::dvec3 origin;
  EmbreeScene scene{};  // of a part
};

struct Cast {
  explicit Cast(const BoxTree::Visit& of) : visit(&of) { rtcInitIntersectContext(&context); }
  RTCIntersectContext context;  // stands first: Embree hands on its address
  const BoxTree::Visit* visit;
};

// The part of a segment near enough to the boxes for floats; shares.
struct Span {
  double begin = 0, end = 1;
};
std::optional<Span> within(const BoxTree::Space& space, const glm::dvec3& from, const glm::dvec3& to) {
  Span span;
  for (int axis = 0; axis < 3; ++axis) {
    const double at = from[axis] - space.origin[axis], way = to[axis] - from[axis];
    const double reach = (1 + 2 * kFloats) * space.reach_m + space.margin_m;
    if (way == 0) {
      if (std::fabs(at) > reach) return std::nullopt;
      continue;
    }
    const double low = (-reach - at) / way, high = (reach - at) / way;
    span.begin = std::max(span.begin, std::min(low, high));
    span.end = std::min(span.end, std::max(low, high));
  }
  if (!(span.begin < span.end)) return std::nullopt;
  return span;
}

void bound(const RTCBoundsFunctionArguments* args) {
  const auto& boxes = *static_cast<const Boxes*>(args->geometryUserPtr);
  const Box box = boxes.of(args->primID);
  const glm::vec3 low(box.low - boxes.origin - boxes.margin), high(box.high - boxes.origin + boxes.margin);
  RTCBounds& out = *args->bounds_o;
  out.lower_x = low.x, out.lower_y = low.y, out.lower_z = low.z;
  out.upper_x = high.x, out.upper_y = high.y, out.upper_z = high.z;
}

double visit(RTCIntersectContext* context, uint32_t box) {
  const unsigned instance = context->instID[0];
  const int32_t number =
      instance == RTC_INVALID_GEOMETRY_ID ? BoxTree::kNoInstance : static_cast<int32_t>(instance - 1 - kBoxesGeometry);
  return (*reinterpret_cast<const Cast*>(context)->visit)(number, box);
}

// One ray at a time, as rtcOccluded1 and rtcIntersect1 cast them.
void visitAny(const RTCOccludedFunctionNArguments* args) {
  if (args->valid[0] != 0 && visit(args->context, args->primID) < 0)
    reinterpret_cast<RTCRay*>(args->ray)->tfar = -std::numeric_limits<float>::infinity();
}

void visitInOrder(const RTCIntersectFunctionNArguments* args) {
  if (args->valid[0] == 0) return;
  const double last = visit(args->context, args->primID);
  // Rounded up, so that what is as near is visited.
  const float shown = std::nextafter(static_cast<float>(last), std::numeric_limits<float>::infinity());
  RTCRay& ray = reinterpret_cast<RTCRayHit*>(args->rayhit)->ray;
  ray.tfar = std::min(ray.tfar, shown);
}

}  // namespace

struct BoxTree::Embree {
  Embree(const Space& of, uint64_t max_bytes) : space(of), device(EmbreeDevice::Threads::kOne, max_bytes) {
    CHECK_TRUE(device.handle() != nullptr);  // a processor without SSE2, which this is not built for
    scene = device.newScene();
  }

  Status status() const {
    const RTCError error = device.error();
    if (error == RTC_ERROR_NONE) return {};
    if (error == RTC_ERROR_OUT_OF_MEMORY)
      return Error{ErrorCode::kLimit, "the scene at full resolution takes more memory than lines of sight may have"};
    return Error{ErrorCode::kUnsupported, "Embree refuses the scene with its error " + std::to_string(error)};
  }

  Status addTo(RTCScene to, RTCGeometry geometry, uint32_t id) const {
    if (to == nullptr || geometry == nullptr) return status();
    rtcCommitGeometry(geometry);
    rtcAttachGeometryByID(to, geometry, id);
    rtcReleaseGeometry(geometry);
    return status();
  }

  Status addBoxesTo(RTCScene to, uint32_t count, Boxes& boxes) const {
    RTCGeometry geometry = rtcNewGeometry(device.handle(), RTC_GEOMETRY_TYPE_USER);
    if (geometry == nullptr) return status();
    rtcSetGeometryUserPrimitiveCount(geometry, count);
    rtcSetGeometryUserData(geometry, &boxes);
    rtcSetGeometryBoundsFunction(geometry, bound, nullptr);  // which is given the geometry's data
    rtcSetGeometryIntersectFunction(geometry, visitInOrder);
    rtcSetGeometryOccludedFunction(geometry, visitAny);
    return addTo(to, geometry, kBoxesGeometry);
  }

  Status commit(RTCScene of) const {
    rtcSetSceneFlags(of, static_cast<RTCSceneFlags>(RTC_SCENE_FLAG_ROBUST | RTC_SCENE_FLAG_COMPACT));
    rtcCommitScene(of);
    return status();
  }

  const Space space;
  EmbreeDevice device;  // outlives all scenes
  std::unique_ptr<Boxes> standing;
  std::vector<std::unique_ptr<Boxes>> parts;
  EmbreeScene scene;
  uint32_t instances = 0;
};

BoxTree::BoxTree(const Space& space, uint64_t max_bytes) : embree_(std::make_unique<Embree>(space, max_bytes)) {}
BoxTree::~BoxTree() = default;
BoxTree::BoxTree(BoxTree&&) noexcept = default;
BoxTree& BoxTree::operator=(BoxTree&&) noexcept = default;

Status BoxTree::addBoxes(uint32_t count, BoxOf box_of) {
  const Space& space = embree_->space;
  embree_->standing =
      std::make_unique<Boxes>(Boxes{std::move(box_of), space.margin_m + kFloats * space.reach_m, space.origin, {}});
  return embree_->addBoxesTo(embree_->scene.get(), count, *embree_->standing);
}

Result<uint32_t> BoxTree::addPart(uint32_t count, BoxOf box_of, double scale) {
  const Space& space = embree_->space;
  embree_->parts.push_back(std::make_unique<Boxes>(
      Boxes{std::move(box_of), (space.margin_m + kFloats * space.reach_m) / scale, glm::dvec3(0), {}}));
  Boxes& part = *embree_->parts.back();
  part.scene = embree_->device.newScene();
  if (Status s = embree_->addBoxesTo(part.scene.get(), count, part); !s.ok()) return s.error();
  if (Status s = embree_->commit(part.scene.get()); !s.ok()) return s.error();
  return static_cast<uint32_t>(embree_->parts.size() - 1);
}

Status BoxTree::addInstance(uint32_t part, const glm::dmat3& linear, const glm::dvec3& offset) {
  RTCGeometry geometry = rtcNewGeometry(embree_->device.handle(), RTC_GEOMETRY_TYPE_INSTANCE);
  if (geometry == nullptr) return embree_->status();
  rtcSetGeometryInstancedScene(geometry, embree_->parts[part]->scene.get());
  rtcSetGeometryTimeStepCount(geometry, 1);
  const std::array<glm::vec3, 4> columns{glm::vec3(linear[0]), glm::vec3(linear[1]), glm::vec3(linear[2]),
                                         glm::vec3(offset - embree_->space.origin)};
  rtcSetGeometryTransform(geometry, 0, RTC_FORMAT_FLOAT3X4_COLUMN_MAJOR, columns.data());
  return embree_->addTo(embree_->scene.get(), geometry, 1 + kBoxesGeometry + embree_->instances++);
}

Status BoxTree::commit() {
  if (embree_->scene == nullptr) return embree_->status();
  return embree_->commit(embree_->scene.get());
}

void BoxTree::castInOrder(const glm::dvec3& from, const glm::dvec3& to, const Visit& visit) const {
  const std::optional<Span> span = within(embree_->space, from, to);
  if (!span) return;
  const double length = span->end - span->begin;
  const Visit of_span = [&](int32_t instance, uint32_t box) { return (visit(instance, box) - span->begin) / length; };
  Cast cast(of_span);
  RTCRayHit hit{};
  hit.ray = embreeRay(from + span->begin * (to - from) - embree_->space.origin, length * (to - from));
  hit.hit.geomID = hit.hit.instID[0] = RTC_INVALID_GEOMETRY_ID;
  rtcIntersect1(embree_->scene.get(), &cast.context, &hit);
}

void BoxTree::cast(const glm::dvec3& from, const glm::dvec3& to, const Visit& visit) const {
  const std::optional<Span> span = within(embree_->space, from, to);
  if (!span) return;
  Cast cast(visit);
  RTCRay ray =
      embreeRay(from + span->begin * (to - from) - embree_->space.origin, (span->end - span->begin) * (to - from));
  rtcOccluded1(embree_->scene.get(), &cast.context, &ray);
}

uint64_t BoxTree::bytes() const { return embree_->device.bytes(); }

}  // namespace foreland::server
