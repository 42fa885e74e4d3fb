#include "server/occlusion/objects/object_solids.h"

#include <embree3/rtcore.h>

#include <algorithm>
#include <glm/geometric.hpp>
#include <limits>

namespace foreland::server {

namespace {

constexpr double kDepthRounding_m = 1e-5;  // of depths, of coordinates up to 10^6 m
constexpr double kFloatPad_m = 0.25;       // that the boxes which Embree reads, in floats, are larger

std::array<glm::dvec3, 8> boxCorners(const proto::ObjectPlacement& placement, const glm::dvec3& low,
                                     const glm::dvec3& high) {
  std::array<glm::dvec3, 8> corners;
  for (size_t i = 0; i < corners.size(); ++i)
    corners[i] = placement.toScene(
        {(i & 1) != 0 ? high.x : low.x, (i & 2) != 0 ? high.y : low.y, (i & 4) != 0 ? high.z : low.z});
  return corners;
}

}  // namespace

struct ObjectSolids::Embree {
  RTCDevice device = nullptr;
  RTCScene scene = nullptr;
  ~Embree() {
    if (scene) rtcReleaseScene(scene);
    if (device) rtcReleaseDevice(device);
  }
};

// What is asked of each solid that the ray comes to.
struct ObjectSolids::Query {
  RTCIntersectContext context;  // first: Embree hands it to the callback
  const ObjectSolids* all;
  const EyeCapsule* eyes;
  std::span<const glm::dvec3> target;
  double rho_m;
  uint32_t found = kNone;
};

Result<std::shared_ptr<const ObjectSolids>> ObjectSolids::create(const SceneObjects& objects) {
  std::shared_ptr<ObjectSolids> made(new ObjectSolids());
  for (size_t i = 0; i < objects.set.size(); ++i) {
    made->addObject(objects, i);
    made->addSolids(objects, i);
  }
  if (Status s = made->build(); !s.ok()) return s.error();
  return std::shared_ptr<const ObjectSolids>(std::move(made));
}

ObjectSolids::~ObjectSolids() = default;

void ObjectSolids::addObject(const SceneObjects& objects, size_t object) {
  const proto::ObjectPlacement& placement = objects.set.placement(object);
  const auto& [low, high] = objects.hulls[placement.model].box;
  Box box{boxCorners(placement, low, high), low, high, placement.position, placement.orientation, placement.scale};
  // What the ground carries moves along one line; the box is made longer on the side that it moves to.
  if (!placement.rise.isStill()) {
    const glm::dvec3 middle = placement.toScene(0.5 * (low + high));
    const auto [lowest, highest] = placement.rise.range;
    for (glm::dvec3& corner : box.corners) {
      const bool is_above = glm::dot(corner - middle, placement.rise.quantum) > 0;
      corner += (is_above ? highest : lowest) * placement.rise.quantum;
    }
  }
  boxes_.push_back(box);
}

void ObjectSolids::addSolids(const SceneObjects& objects, size_t object) {
  const proto::ObjectPlacement& placement = objects.set.placement(object);
  if (!placement.rise.isStill() || !objects.set.modelOf(object).pose_epochs.empty()) return;
  for (const terrain::ConvexSolid& inner : objects.hulls[placement.model].solids) {
    Solid solid;
    solid.object = static_cast<uint32_t>(object);
    for (const terrain::SolidPlane& plane : inner.planes()) {
      const glm::dvec3 normal = placement.orientation * plane.normal;
      solid.planes[solid.plane_count++] = {normal,
                                           plane.offset * placement.scale + glm::dot(normal, placement.position)};
    }
    solid.low = glm::dvec3(std::numeric_limits<double>::infinity());
    solid.high = -solid.low;
    for (const glm::dvec3& p : boxCorners(placement, inner.low, inner.high)) {
      solid.low = glm::min(solid.low, p);
      solid.high = glm::max(solid.high, p);
    }
    solids_.push_back(solid);
  }
}

// The callback of Embree accepts a solid that hides the target, and lets the ray go on past others.
Status ObjectSolids::build() {
  if (solids_.empty()) return {};
  origin_ = 0.5 * (solids_.front().low + solids_.front().high);
  embree_ = std::make_unique<Embree>();
  embree_->device = rtcNewDevice("threads=1");
  if (!embree_->device) return Error{ErrorCode::kLimit, "Embree cannot be used for what objects hide"};
  embree_->scene = rtcNewScene(embree_->device);
  rtcSetSceneFlags(embree_->scene, RTC_SCENE_FLAG_ROBUST);
  const RTCGeometry geometry = rtcNewGeometry(embree_->device, RTC_GEOMETRY_TYPE_USER);
  rtcSetGeometryUserPrimitiveCount(geometry, static_cast<unsigned>(solids_.size()));
  rtcSetGeometryUserData(geometry, this);
  rtcSetGeometryBoundsFunction(
      geometry,
      [](const RTCBoundsFunctionArguments* args) {
        const auto& all = *static_cast<const ObjectSolids*>(args->geometryUserPtr);
        const Solid& solid = all.solids_[args->primID];
        const glm::dvec3 low = solid.low - all.origin_ - kFloatPad_m, high = solid.high - all.origin_ + kFloatPad_m;
        *args->bounds_o = {static_cast<float>(low.x),  static_cast<float>(low.y),  static_cast<float>(low.z),  0,
                           static_cast<float>(high.x), static_cast<float>(high.y), static_cast<float>(high.z), 0};
      },
      nullptr);
  rtcSetGeometryOccludedFunction(geometry, [](const RTCOccludedFunctionNArguments* args) {
    if (args->valid[0] != -1) return;
    Query& query = *reinterpret_cast<Query*>(args->context);
    if (!query.all->hides(query.all->solids_[args->primID], query)) return;
    query.found = args->primID;
    RTCRayN_tfar(args->ray, args->N, 0) = -std::numeric_limits<float>::infinity();
  });
  rtcCommitGeometry(geometry);
  rtcAttachGeometry(embree_->scene, geometry);
  rtcReleaseGeometry(geometry);
  rtcCommitScene(embree_->scene);
  if (rtcGetDeviceError(embree_->device) != RTC_ERROR_NONE)
    return Error{ErrorCode::kLimit, "there is not enough memory for what objects hide"};
  return {};
}

// Whether the eyes come to the box of the solid's object, by the box of the capsule in the object's frame.
bool ObjectSolids::mayBeInside(const Solid& solid, const EyeCapsule& eyes) const {
  const Box& box = boxes_[solid.object];
  const glm::dquat back = glm::conjugate(box.orientation);
  const glm::dvec3 a = back * (eyes.eye - box.position) / box.scale,
                   b = back * (eyes.eye + eyes.way - box.position) / box.scale;
  const double r = (eyes.radius_m + kDepthRounding_m) / box.scale;
  for (int axis = 0; axis < 3; ++axis)
    if (std::max(a[axis], b[axis]) + r < box.low[axis] || std::min(a[axis], b[axis]) - r > box.high[axis]) return false;
  return true;
}

bool ObjectSolids::hides(const Solid& solid, const Query& query) const {
  const EyeCapsule& eyes = *query.eyes;
  if (mayBeInside(solid, eyes)) return false;
  std::array<std::array<double, 8>, 2> eye_depth;
  const std::array ends{eyes.eye, eyes.eye + eyes.way};
  for (size_t e = 0; e < 2; ++e)
    for (uint32_t k = 0; k < solid.plane_count; ++k)
      eye_depth[e][k] =
          glm::dot(solid.planes[k].normal, ends[e]) - solid.planes[k].offset - eyes.radius_m - kDepthRounding_m;
  for (const glm::dvec3& t : query.target) {
    std::array<double, 2> from{0, 0}, to{1, 1};  // the shares of the lines at which they are deep enough
    for (uint32_t k = 0; k < solid.plane_count; ++k) {
      const double b = glm::dot(solid.planes[k].normal, t) - solid.planes[k].offset - query.rho_m - kDepthRounding_m;
      for (size_t e = 0; e < 2; ++e) {
        const double a = eye_depth[e][k];
        if (a < 0 && b < 0) return false;
        if (a < 0) from[e] = std::max(from[e], a / (a - b));
        if (b < 0) to[e] = std::min(to[e], a / (a - b));
      }
    }
    if (from[0] > to[0] || from[1] > to[1]) return false;
  }
  return true;
}

uint32_t ObjectSolids::hiding(const EyeCapsule& eyes, std::span<const glm::dvec3> target, double rho_m,
                              uint32_t first) const {
  if (solids_.empty()) return kNone;
  Query query{.context = {}, .all = this, .eyes = &eyes, .target = target, .rho_m = rho_m};
  if (first < solids_.size() && hides(solids_[first], query)) return first;
  rtcInitIntersectContext(&query.context);
  glm::dvec3 middle{0};
  for (const glm::dvec3& t : target) middle += t / static_cast<double>(target.size());
  const glm::dvec3 start = eyes.eye + 0.5 * eyes.way, way = middle - start;
  RTCRay ray{};
  ray.org_x = static_cast<float>(start.x - origin_.x);
  ray.org_y = static_cast<float>(start.y - origin_.y);
  ray.org_z = static_cast<float>(start.z - origin_.z);
  ray.dir_x = static_cast<float>(way.x);
  ray.dir_y = static_cast<float>(way.y);
  ray.dir_z = static_cast<float>(way.z);
  ray.tfar = 1;
  ray.mask = ~0u;
  rtcOccluded1(embree_->scene, &query.context, &ray);
  return query.found;
}

size_t ObjectSolids::bytes() const {
  constexpr size_t kEmbree = 200;  // a solid
  return solids_.capacity() * (sizeof(Solid) + kEmbree) + boxes_.capacity() * sizeof(Box);
}

}  // namespace foreland::server
