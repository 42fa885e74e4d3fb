#include "proto/message/sight_message.h"

#include <algorithm>
#include <cmath>

#include "proto/message/control_buffer.h"

namespace foreland::proto {

namespace {

constexpr double kMaxLattice = 1e9;  // either way
constexpr int kCellsPerByte = 4;

fb::Vec3 bufferOf3(const glm::dvec3& v) { return {v.x, v.y, v.z}; }
glm::dvec3 vectorOf3(const fb::Vec3& v) { return {v.x(), v.y(), v.z()}; }

// False for what is not finite.
bool isWithin(double value, double least, double most) { return value >= least && value <= most; }
bool isLattice(double value) { return isWithin(value, -kMaxLattice, kMaxLattice); }
bool isRefraction(double value) { return isWithin(value, 0, 1); }
bool isSceneTime(int64_t us) { return us >= -Epochs::kMaxTime_us && us <= Epochs::kMaxTime_us; }

auto putVectors(Builder& b, const std::vector<glm::dvec3>& vectors) {
  return b.CreateVectorOfStructs<fb::Vec3>(vectors.size(),
                                           [&](size_t i, fb::Vec3* out) { *out = bufferOf3(vectors[i]); });
}

Status checkGrid(const fb::ViewshedReply& m) {
  const uint64_t cells = uint64_t{m.columns()} * m.rows(), told = m.count();
  if (cells > kMaxViewshedCells || told > kMaxCellsTold || m.begin() + told > cells)
    return malformed("a viewshed of more cells than may be");
  if ((m.cells() ? m.cells()->size() : 0) != (told + kCellsPerByte - 1) / kCellsPerByte)
    return malformed("a viewshed's cells are not those that it counts");
  const auto isUsable = [](const fb::Vec2* v) { return v && isLattice(v->x()) && isLattice(v->y()); };
  if (!isUsable(m.first()) || !isUsable(m.step())) return malformed("a viewshed's place is absurd");
  return {};
}

}  // namespace

Bytes encode(const SightRequest& m) {
  Builder b;
  const auto ends = putVectors(b, m.ends);
  return finish(
      b, fb::Body_SightRequest,
      fb::CreateSightRequest(b, m.id, ends, static_cast<uint8_t>(m.above), m.refraction, m.scene_time.us).Union());
}

Bytes encode(const ViewshedRequest& m) {
  Builder b;
  const fb::Vec2 observer = bufferOf(m.observer);
  return finish(b, fb::Body_ViewshedRequest,
                fb::CreateViewshedRequest(b, m.id, &observer, m.observer_m, m.target_m, m.radius_m, m.cell_m,
                                          m.refraction, m.scene_time.us)
                    .Union());
}

Bytes encode(const RequestCancel& m) {
  Builder b;
  return finish(b, fb::Body_RequestCancel, fb::CreateRequestCancel(b, m.id).Union());
}

Bytes encode(const SightReply& m) {
  Builder b;
  const auto error = m.error.empty() ? 0 : b.CreateString(m.error);
  const auto ends = putVectors(b, m.ends);
  const auto hits = b.CreateVectorOfStructs<fb::SightHit>(m.hits.size(), [&](size_t i, fb::SightHit* out) {
    *out = fb::SightHit(bufferOf3(m.hits[i].position), m.hits[i].what);
  });
  return finish(b, fb::Body_SightReply, fb::CreateSightReply(b, m.id, error, ends, hits).Union());
}

Bytes encode(const ViewshedReply& m) {
  std::vector<uint8_t> packed((m.cells.size() + kCellsPerByte - 1) / kCellsPerByte, 0);
  for (size_t i = 0; i < m.cells.size(); ++i)
    packed[i / kCellsPerByte] =
        static_cast<uint8_t>(packed[i / kCellsPerByte] | static_cast<uint8_t>(m.cells[i]) << (2 * (i % kCellsPerByte)));
  Builder b;
  const auto error = m.error.empty() ? 0 : b.CreateString(m.error);
  const auto cells = b.CreateVector(packed);
  const fb::Vec2 first = bufferOf(m.first), step = bufferOf(m.step);
  return finish(b, fb::Body_ViewshedReply,
                fb::CreateViewshedReply(b, m.id, error, &first, &step, m.columns, m.rows, m.begin,
                                        static_cast<uint32_t>(m.cells.size()), cells)
                    .Union());
}

Result<SightRequest> readSightRequest(const fb::SightRequest& m) {
  SightRequest out{m.id(), {}, static_cast<Above>(m.above()), m.refraction(), Time{m.scene_time_us()}};
  const size_t ends = m.ends() ? m.ends()->size() : 0;
  if (ends == 0 || ends % 2 != 0 || ends > 2 * kMaxSightPairs)
    return malformed("a request for lines of sight has 1 to 4096 pairs of ends");
  if (m.above() > 1 || !isRefraction(out.refraction) || !isSceneTime(m.scene_time_us()))
    return malformed(
        "lines of sight: heights above what is unknown, a refraction that is not 0 to 1, or an absurd time");
  for (size_t i = 0; i < ends; ++i) {
    out.ends.push_back(vectorOf3(structAt(*m.ends(), i)));
    const glm::dvec3& end = out.ends.back();
    if (!isLattice(end.x) || !isLattice(end.y) || !isWithin(end.z, -kMaxSightHeight_m, kMaxSightHeight_m))
      return malformed("an end of a line of sight is not finite or too far away");
  }
  return out;
}

Result<ViewshedRequest> readViewshedRequest(const fb::ViewshedRequest& m) {
  if (!m.observer() || !isLattice(m.observer()->x()) || !isLattice(m.observer()->y()))
    return malformed("a viewshed's observer is nowhere");
  const ViewshedRequest out{m.id(),     vectorOf(*m.observer()), m.observer_m(),         m.target_m(), m.radius_m(),
                            m.cell_m(), m.refraction(),          Time{m.scene_time_us()}};
  if (!isWithin(out.observer_m, 0, kMaxSightHeight_m) || !isWithin(out.target_m, 0, kMaxSightHeight_m))
    return malformed("a viewshed's heights must be 0 to 1,000,000 m above the ground");
  if (!isWithin(out.radius_m, kMinSightLength_m, kMaxSightRadius_m) ||
      !isWithin(out.cell_m, kMinSightLength_m, kMaxSightRadius_m))
    return malformed("a viewshed's radius and its cells must be 0.001 to 10,000,000 m");
  if (!isRefraction(out.refraction) || !isSceneTime(m.scene_time_us()))
    return malformed("a viewshed's refraction must be 0 to 1, and its time not absurd");
  return out;
}

Result<SightReply> readSightReply(const fb::SightReply& m) {
  SightReply out{m.id(), text(m.error(), kMaxTextBytes), {}, {}};
  const size_t ends = m.ends() ? m.ends()->size() : 0, hits = m.hits() ? m.hits()->size() : 0;
  if (ends != 2 * hits || hits > kMaxSightPairs) return malformed("lines of sight are told for other than their ends");
  for (size_t i = 0; i < ends; ++i) out.ends.push_back(vectorOf3(structAt(*m.ends(), i)));
  for (size_t i = 0; i < hits; ++i) {
    const fb::SightHit hit = structAt(*m.hits(), i);
    out.hits.push_back({vectorOf3(hit.position()), hit.what()});
  }
  return out;
}

Result<ViewshedReply> readViewshedReply(const fb::ViewshedReply& m) {
  if (Status s = checkGrid(m); !s.ok()) return s.error();
  ViewshedReply out{m.id(),
                    text(m.error(), kMaxTextBytes),
                    vectorOf(*m.first()),
                    vectorOf(*m.step()),
                    m.columns(),
                    m.rows(),
                    m.begin(),
                    {}};
  for (uint32_t i = 0; i < m.count(); ++i) {
    const int cell = m.cells()->Get(i / kCellsPerByte) >> (2 * (i % kCellsPerByte)) & 3;
    if (cell > 2) return malformed("a viewshed's cell is neither seen nor hidden");
    out.cells.push_back(static_cast<ViewshedCell>(cell));
  }
  return out;
}

}  // namespace foreland::proto
