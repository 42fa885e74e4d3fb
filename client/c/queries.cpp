// The functions of foreland.h about places, and questions to the server. The conventions are those of foreland.cpp.
#include <cmath>
#include <limits>

#include "client/c/calls.h"
#include "client/ground/sweep.h"

namespace foreland::client {
namespace {

constexpr double kEye_m = 1.7;
constexpr Time kLastEpoch{int64_t{1} << 60};

bool isFinite(const glm::dvec3& v) { return std::isfinite(v.x) && std::isfinite(v.y) && std::isfinite(v.z); }
bool isFinite(const ForelandMapPoint& p) { return isFinite(glm::dvec3(p.x, p.y, p.height)); }

constexpr const char* kNotFinite = "A point, place or length is not finite.";

// Of ForelandSightOptions and ForelandViewshedQuestion, whose members have the same names.
template <class Asked>
double refractionOf(const Asked& asked) {
  return asked.has_refraction != 0 ? asked.refraction : proto::kUsualRefraction;
}
template <class Asked>
Time sceneTimeOf(const Asked& asked) {
  const bool is_given = asked.has_scene_time != 0 && std::abs(asked.scene_time) < 8.64e15;
  return is_given ? Time{std::llround(asked.scene_time * 1000)} : kLastEpoch;
}

template <class Request, class Told>
ForelandStatus ask(Terrain& t, Request request, uint64_t* question) {
  if (Status s = isTaken(request); !s.ok()) return refuse(s.error());
  *question = t.newQuestion();
  t.tell(Told{*question, std::move(request)});
  return FORELAND_OK;
}

}  // namespace
}  // namespace foreland::client

using namespace foreland;          // NOLINT: the functions below are C's
using namespace foreland::client;  // NOLINT

// NOLINTBEGIN(readability-identifier-naming): C's names

ForelandStatus foreland_to_geodetic(ForelandTerrain* terrain, const double point[3], ForelandPlace* out) {
  const auto work = [&](Terrain& t) {
    if (!hasSize(out)) return refuse(FORELAND_ARGUMENT, kNoSize);
    if (!isFinite(vectorOf(point))) return refuse(FORELAND_ARGUMENT, kNotFinite);
    writeStruct(t.placeOf(vectorOf(point)), out);
    return ForelandStatus{FORELAND_OK};
  };
  return withScene(terrain, work, point, out);
}

ForelandStatus foreland_to_scene(ForelandTerrain* terrain, const ForelandMapPoint* place, double out[3]) {
  const auto work = [&](Terrain& t) {
    if (!isFinite(*place)) return refuse(FORELAND_ARGUMENT, kNotFinite);
    put(t.pointOf(*place), out);
    return ForelandStatus{FORELAND_OK};
  };
  return withScene(terrain, work, place, out);
}

ForelandStatus foreland_height_now(ForelandTerrain* terrain, const ForelandMapPoint* place, double* out) {
  const auto work = [&](Terrain& t) {
    if (!isFinite(*place)) return refuse(FORELAND_ARGUMENT, kNotFinite);
    const auto height_m = t.screen().ground.heights().heightAt(t.latticeOf(*place));
    if (!height_m || std::isnan(*height_m)) return refuse(FORELAND_NOTHING, "No ground is known there now.");
    *out = *height_m;
    return ForelandStatus{FORELAND_OK};
  };
  return withScene(terrain, work, place, out);
}

ForelandStatus foreland_sweep(ForelandTerrain* terrain, const double from[3], const double to[3], double clearance,
                              double out[3]) {
  const auto work = [&](Terrain& t) {
    if (!isFinite(vectorOf(from)) || !isFinite(vectorOf(to)) || !std::isfinite(clearance))
      return refuse(FORELAND_ARGUMENT, kNotFinite);
    const Screen& s = t.screen();
    put(sweep(s.ground.heights(), *s.transform, vectorOf(from), vectorOf(to), clearance), out);
    return ForelandStatus{FORELAND_OK};
  };
  return withScene(terrain, work, from, to, out);
}

ForelandStatus foreland_raycast(ForelandTerrain* terrain, const double origin[3], const double direction[3], double far,
                                double out[3]) {
  const auto work = [&](Terrain& t) {
    const Ray ray{vectorOf(origin), vectorOf(direction), far};
    if (!isFinite(ray.origin) || !isFinite(ray.direction) || ray.direction == glm::dvec3(0) || std::isnan(far))
      return refuse(FORELAND_ARGUMENT, "A ray has a finite origin, and a direction of some length.");
    const auto hit = t.screen().groundOn(ray);
    if (!hit) return refuse(FORELAND_NOTHING, "The ray meets no ground that is known now.");
    put(*hit, out);
    return ForelandStatus{FORELAND_OK};
  };
  return withScene(terrain, work, origin, direction, out);
}

ForelandStatus foreland_heights(ForelandTerrain* terrain, const ForelandMapPoint* places, uint32_t count,
                                uint64_t* question) {
  const auto work = [&](Terrain& t) {
    if (count == 0 || count > proto::kMaxGroundPoints)
      return refuse(FORELAND_ARGUMENT, "Ask for the heights of 1 to 65,536 places at once.");
    std::vector<glm::dvec2> positions;
    for (const ForelandMapPoint* place = places; place != places + count; ++place) {
      if (!isFinite(*place)) return refuse(FORELAND_ARGUMENT, kNotFinite);
      positions.push_back(t.latticeOf(*place));
    }
    *question = t.newQuestion();
    t.tell(told::Heights{*question, std::move(positions)});
    return ForelandStatus{FORELAND_OK};
  };
  return withScene(terrain, work, places, question);
}

ForelandStatus foreland_visible(ForelandTerrain* terrain, const ForelandMapPoint* pairs, uint32_t pair_count,
                                const ForelandSightOptions* options, uint64_t* question) {
  const auto work = [&](Terrain& t) {
    if (options != nullptr && !hasSize(options)) return refuse(FORELAND_ARGUMENT, kNoSize);
    if (pair_count == 0 || pair_count > proto::kMaxSightPairs)
      return refuse(FORELAND_ARGUMENT, "Ask about 1 to 4,096 pairs of places at once.");
    const ForelandSightOptions chosen = options != nullptr ? readStruct(*options) : ForelandSightOptions{};
    proto::SightRequest request{.ends = {},
                                .above = chosen.above_ground != 0 ? proto::Above::kGround : proto::Above::kZeroSurface,
                                .refraction = refractionOf(chosen),
                                .scene_time = sceneTimeOf(chosen)};
    for (const ForelandMapPoint* place = pairs; place != pairs + size_t{2} * pair_count; ++place) {
      if (!isFinite(*place)) return refuse(FORELAND_ARGUMENT, kNotFinite);
      request.ends.emplace_back(t.latticeOf(*place), place->height);
    }
    return ask<proto::SightRequest, told::Sight>(t, std::move(request), question);
  };
  return withScene(terrain, work, pairs, question);
}

ForelandStatus foreland_viewshed(ForelandTerrain* terrain, const ForelandViewshedQuestion* asked, uint64_t* question) {
  const auto work = [&](Terrain& t) {
    if (!hasSize(asked)) return refuse(FORELAND_ARGUMENT, kNoSize);
    const ForelandViewshedQuestion q = readStruct(*asked);
    if (!isFinite(q.from)) return refuse(FORELAND_ARGUMENT, kNotFinite);
    proto::ViewshedRequest request{.observer = t.latticeOf(q.from),
                                   .observer_m = q.from.height != 0 ? q.from.height : kEye_m,
                                   .target_m = q.target,
                                   .radius_m = q.radius,
                                   .cell_m = q.cell,
                                   .refraction = refractionOf(q),
                                   .scene_time = sceneTimeOf(q)};
    return ask<proto::ViewshedRequest, told::Viewshed>(t, std::move(request), question);
  };
  return withScene(terrain, work, asked, question);
}

ForelandStatus foreland_cancel(ForelandTerrain* terrain, uint64_t question) {
  return withTerrain(terrain, [&](Terrain& t) -> ForelandStatus {
    t.cancel(question);
    return FORELAND_OK;
  });
}

// NOLINTEND(readability-identifier-naming)
