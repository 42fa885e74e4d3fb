#include <algorithm>
#include <cmath>
#include <cstring>
#include <glm/geometric.hpp>
#include <glm/mat3x3.hpp>

#include "terrain/objects/placed_objects.h"
#include "terrain/objects/section_bytes.h"

namespace foreland::terrain {

namespace {

constexpr double kRadians = 0.017453292519943295;

Error refused(const ObjectRequest& request, const std::string& what) {
  return {ErrorCode::kInvalidArgument, "object " + request.model.string() + ": " + what};
}

// The lattice position of the coordinates in a request.
glm::dvec2 latticePlace(const proto::FrameTransform& transform, const glm::dvec2& at) {
  const proto::Frame& frame = transform.frame();
  if (frame.kind == proto::FrameKind::kGlobe) {
    const proto::CubePoint p =
        proto::cubePoint(transform.upAt(transform.toScene(proto::Geodetic{at.x * kRadians, at.y * kRadians, 0})));
    const auto share = [](double s) { return std::min(0.5 * (s + 1), 1 - 1e-12); };  // within the face
    return glm::dvec2(p.face + share(p.s), share(p.t)) * (1.0 * frame.face_steps);
  }
  if (frame.kind == proto::FrameKind::kGeographic)
    return {(at.y * kRadians - frame.longitude0_rad) / frame.longitude_step_rad,
            (at.x * kRadians - frame.latitude0_rad) / frame.latitude_step_rad};
  const glm::dvec2 d = at - frame.map_origin_m, x = frame.axis_x_m, y = frame.axis_y_m;
  const double det = x.x * y.y - x.y * y.x;
  return frame.anchor + glm::dvec2((d.x * y.y - d.y * y.x) / det, (x.x * d.y - x.y * d.x) / det);
}

// East, north and up at a point, turned clockwise by the heading. At a globe's poles north is along the meridians of
// 180 and of 0 degrees.
glm::dquat standing(const proto::Frame& frame, const glm::dvec3& up, double heading_rad) {
  glm::dvec3 towards(0, 1, 0);
  if (frame.kind == proto::FrameKind::kGlobe)
    towards = std::hypot(up.x, up.y) > 1e-9 ? glm::dvec3(0, 0, 1) : glm::dvec3(-up.z, 0, 0);
  const glm::dvec3 north = glm::normalize(towards - up * glm::dot(up, towards)), east = glm::cross(north, up);
  const double c = std::cos(heading_rad), s = std::sin(heading_rad);
  return glm::normalize(glm::quat_cast(glm::dmat3(c * east - s * north, s * east + c * north, up)));
}

// Where the model's own coordinates are: metres of the map, by the scale, and heights above the zero surface.
Result<proto::ObjectPlacement> placeAsItIs(const ObjectRequest& request, const MappedSurface& model,
                                           const proto::FrameTransform& transform,
                                           const std::function<std::optional<double>(double, double)>& groundAt) {
  const proto::Frame& frame = transform.frame();
  if (frame.kind != proto::FrameKind::kPlanar)
    return refused(request,
                   "@here means coordinates of a map, but the scene is in latitude and longitude; give "
                   "LAT,LON, or build the scene of a raster in the model's reference system");
  const SurfaceHeader& h = model.header();
  const glm::dvec3 origin = model.origin() * request.scale;
  const glm::dvec2 middle =
      glm::dvec2(origin) + request.scale * model.quantumMetres() / 2 *
                               glm::dvec2(double(h.low[0]) + h.high[0], double(h.low[1]) + h.high[1]);
  const glm::dvec2 at = latticePlace(transform, middle);
  if (!groundAt(at.x, at.y))
    return refused(request, "its own place, (" + std::to_string(middle.x) + ", " + std::to_string(middle.y) +
                                ") on the map, lies beyond the data; build the scene in the model's reference system, "
                                "or give x and y of the map, in metres");
  const glm::dvec3 point(glm::dvec2(origin) - frame.map_origin_m, origin.z + request.height_m);
  return proto::ObjectPlacement{0, point, standing(frame, {0, 0, 1}, request.heading_deg * kRadians), request.scale};
}

Result<proto::ObjectPlacement> place(const ObjectRequest& request, const MappedSurface& model,
                                     const proto::FrameTransform& transform,
                                     const std::function<std::optional<double>(double, double)>& groundAt) {
  if (request.is_at_own_place) return placeAsItIs(request, model, transform, groundAt);
  const glm::dvec2 at = latticePlace(transform, request.at);
  const std::optional<double> ground = groundAt(at.x, at.y);
  if (!ground) {
    const bool is_planar = transform.frame().kind == proto::FrameKind::kPlanar;
    return refused(request, "(" + std::to_string(request.at.x) + ", " + std::to_string(request.at.y) +
                                ") lies beyond the data; give " +
                                (is_planar ? "x and y of the map, in metres" : "latitude and longitude, in degrees"));
  }
  const double lowest_m = model.header().low[2] * model.quantumMetres() * request.scale;
  const double height_m = *ground + request.height_m;
  const glm::dvec3 point =
      transform.frame().kind == proto::FrameKind::kGlobe
          ? transform.toScene(proto::Geodetic{request.at.x * kRadians, request.at.y * kRadians, height_m})
          : transform.toScene(proto::LatticePosition{at.x, at.y, height_m});
  const glm::dvec3 up = transform.upAt(point);
  return proto::ObjectPlacement{0, point - up * lowest_m,
                                standing(transform.frame(), up, request.heading_deg * kRadians), request.scale};
}

StoredPlacement stored(const proto::ObjectPlacement& p) {
  const glm::dquat& q = p.orientation;
  return {{p.position.x, p.position.y, p.position.z}, {q.w, q.x, q.y, q.z}, p.scale, p.model, 0};
}

uint64_t pageAbove(uint64_t bytes) { return (bytes + kPageBytes - 1) / kPageBytes * kPageBytes; }

void put(Bytes& out, uint64_t offset, const void* what, uint64_t bytes) {
  std::memcpy(out.data() + offset, what, bytes);
}

}  // namespace

Result<Bytes> makeObjectSection(const std::vector<ObjectRequest>& requests, const proto::Frame& frame,
                                const proto::Epochs& epochs,
                                const std::function<std::optional<double>(double x, double y)>& groundAt) {
  if (requests.empty()) return Bytes();
  if (requests.size() > proto::ObjectSet::kMaxObjects)
    return Error{ErrorCode::kLimit, std::to_string(requests.size()) + " objects; a scene holds at most " +
                                        std::to_string(proto::ObjectSet::kMaxObjects)};
  const proto::FrameTransform transform(frame);
  std::vector<std::shared_ptr<const MappedSurface>> models;
  std::vector<proto::ObjectModel> shapes;
  std::vector<proto::ObjectPlacement> placements;
  for (const ObjectRequest& request : requests) {
    auto surface = MappedSurface::open(request.model);
    if (!surface.ok()) return surface.error();
    if (Status s = checkModel(**surface); !s.ok())
      return refused(request, s.error().message + "; make it anew by foreland remesh");
    const auto same =
        std::find_if(models.begin(), models.end(), [&](const auto& m) { return m->id() == (*surface)->id(); });
    auto placement = place(request, **surface, transform, groundAt);
    if (!placement.ok()) return placement.error();
    placement->model = static_cast<uint32_t>(same - models.begin());
    if (same == models.end()) {
      auto shape = modelOf(**surface, epochs);
      if (!shape.ok())
        return refused(request,
                       shape.error().message + "; give --epoch for the date of each pose, or no --epoch at all");
      models.push_back(*surface);
      shapes.push_back(std::move(*shape));
    }
    placements.push_back(*placement);
  }
  if (auto set = proto::ObjectSet::create(std::move(shapes), placements, epochs); !set.ok())
    return Error{set.error().code, set.error().message +
                                       "; if its surface lies far from its origin, make it anew by foreland remesh, "
                                       "which gives it an origin of its own"};

  uint64_t at =
      sizeof(ObjectSectionStart) + placements.size() * sizeof(StoredPlacement) + models.size() * sizeof(StoredModel);
  std::vector<StoredModel> table;
  for (const auto& m : models) {
    table.push_back({pageAbove(at), m->file().size()});
    at = table.back().offset + table.back().bytes;
  }
  Bytes out(at);
  const ObjectSectionStart start{static_cast<uint32_t>(models.size()), static_cast<uint32_t>(placements.size())};
  put(out, 0, &start, sizeof(start));
  at = sizeof(start);
  for (const auto& p : placements) {
    const StoredPlacement s = stored(p);
    put(out, at, &s, sizeof(s));
    at += sizeof(s);
  }
  put(out, at, table.data(), table.size() * sizeof(StoredModel));
  for (size_t i = 0; i < models.size(); ++i) put(out, table[i].offset, models[i]->file().data(), table[i].bytes);
  return out;
}

}  // namespace foreland::terrain
