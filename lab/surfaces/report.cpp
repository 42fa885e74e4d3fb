#include "lab/surfaces/report.h"

#include <algorithm>
#include <glm/geometric.hpp>
#include <iterator>

#include "base/quantile.h"
#include "base/rng.h"

namespace foreland::lab {

namespace {

using nlohmann::ordered_json;
using proto::ErrorShape;
using terrain::ErrorFit;

constexpr uint64_t kSeed = 1;
constexpr int kDirections = 12;

glm::dvec3 direction(Rng& rng) {
  glm::dvec3 v;
  do v = {rng.uniform(-1, 1), rng.uniform(-1, 1), rng.uniform(-1, 1)};
  while (glm::length(v) > 1 || glm::length(v) < 0.1);
  return glm::normalize(v);
}

// From several directions, at one size on the screen.
ordered_json atDisc(const terrain::TrueSurface& surface, const SurfaceBench& bench, const SurfaceSession& session,
                    double disc) {
  Rng rng(kSeed);
  size_t most = 0;
  double faces = 0, silhouette = 0, interior = 0;
  uint64_t uncovered = 0;
  for (int i = 0; i < kDirections; ++i) {
    const FrameCost cost = bench.measure(session, poseAtDisc(surface, session, disc, direction(rng)));
    most = std::max(most, cost.faces);
    faces += static_cast<double>(cost.faces) / kDirections;
    silhouette = std::max(silhouette, cost.silhouette_error_px);
    interior = std::max(interior, cost.interior_error_px);
    uncovered += cost.uncovered;
  }
  return {{"disc", disc},
          {"faces", faces},
          {"most_faces", most},
          {"max_silhouette_error_px", silhouette},
          {"max_interior_error_px", interior},
          {"uncovered", uncovered}};
}

struct Session {
  std::vector<size_t> faces;
  double mean_faces = 0, silhouette_error_px = 0, interior_error_px = 0;
  uint64_t uncovered = 0;
  std::vector<double> refine_ms, adapt_ms, full_draw_ms, draw_ms;
};

Session replay(const SurfaceBench& bench, const SurfaceSession& session, const std::vector<proto::Pose>& poses) {
  Session all;
  const proto::SurfaceDomain domain = bench.domain(session);
  proto::SurfaceAdapter adapter(domain);
  for (const proto::Pose& pose : poses) {
    all.adapt_ms.push_back(bench.adapt(session, pose, adapter));
    const FrameCost cost = bench.measure(session, pose);
    all.faces.push_back(cost.faces);
    all.mean_faces += static_cast<double>(cost.faces) / static_cast<double>(poses.size());
    all.silhouette_error_px = std::max(all.silhouette_error_px, cost.silhouette_error_px);
    all.interior_error_px = std::max(all.interior_error_px, cost.interior_error_px);
    all.uncovered += cost.uncovered;
    all.refine_ms.push_back(cost.refine_ms);
    all.full_draw_ms.push_back(cost.full_draw_ms);
    all.draw_ms.push_back(cost.draw_ms);
  }
  return all;
}

struct Rival {
  const char* name;
  ErrorShape shape;
  ErrorFit fit;
};
constexpr Rival kRivals[] = {{"spheroid", ErrorShape::kSpheroid, ErrorFit::kSmallest},
                             {"hoppe", ErrorShape::kHoppe, ErrorFit::kSmallest},
                             {"spheroid_by_largest", ErrorShape::kSpheroid, ErrorFit::kByLargest},
                             {"hoppe_by_largest", ErrorShape::kHoppe, ErrorFit::kByLargest}};

ordered_json compareShapes(const terrain::TrueSurface& surface, const SurfaceSession& session,
                           const std::vector<proto::Pose>& poses) {
  std::vector<proto::Pose> some;
  for (size_t i = 0; i < poses.size(); i += 3) some.push_back(poses[i]);
  ordered_json report;
  std::vector<size_t> ours;
  double share = 0;  // the spheroid's error, which the others' tolerances are set to
  for (const Rival& rival : kRivals) {
    const SurfaceBench bench(surface, rival.shape, rival.fit);
    size_t sum = 0, fewer = 0;
    for (size_t i = 0; i < poses.size(); ++i) {
      const size_t faces = bench.faces(session, poses[i], 1);
      sum += faces;
      if (&rival == kRivals)
        ours.push_back(faces);
      else
        fewer += faces < ours[i] ? 1 : 0;
    }
    if (&rival == kRivals) share = bench.meanWorstShare(session, some, 1);
    const SurfaceBench::AtEqualError equal = bench.atEqualError(session, some, share);
    report[rival.name] = {{"mean_faces", static_cast<double>(sum) / static_cast<double>(poses.size())},
                          {"frames_with_fewer_than_spheroid", fewer},
                          {"mean_faces_at_equal_measured_error", equal.faces},
                          {"tolerance_scale_at_equal_measured_error", equal.scale}};
  }
  return report;
}

}  // namespace

ordered_json surfaceReport(const terrain::TrueSurface& surface, const SurfaceSession& session) {
  const SurfaceBench bench(surface, kRivals[0].shape, kRivals[0].fit);
  const std::vector<proto::Pose> poses = sessionPoses(surface, session);
  ordered_json by_disc = ordered_json::array();
  for (double disc : {0.3, 0.4, 0.5, 0.6, 0.7, 0.8, 0.9, 1.0}) by_disc.push_back(atDisc(surface, bench, session, disc));
  const Session all = replay(bench, session, poses);
  const double refine_ms = median(all.refine_ms), adapt_ms = median(all.adapt_ms),
               full_draw_ms = median(all.full_draw_ms);
  return {{"base_faces", surface.topology.base().faceCount()},
          {"full_faces", bench.fullFaces()},
          {"silhouette_px", session.silhouette_px},
          {"interior_px", session.interior_px},
          {"whole_in_view", atDisc(surface, bench, session, session.disc)},
          {"by_disc", by_disc},
          {"session",
           {{"frames", poses.size()},
            {"mean_faces", all.mean_faces},
            {"most_faces", *std::max_element(all.faces.begin(), all.faces.end())},
            {"max_silhouette_error_px", all.silhouette_error_px},
            {"max_interior_error_px", all.interior_error_px},
            {"uncovered", all.uncovered},
            {"faces", all.faces}}},
          {"shapes", compareShapes(surface, session, poses)},
          {"refine_ms", refine_ms},
          {"full_draw_ms", full_draw_ms},
          {"draw_ms", median(all.draw_ms)},
          {"refine_share_of_full_draw", refine_ms / full_draw_ms},
          {"adapt_ms", adapt_ms},
          {"adapt_share_of_full_draw", adapt_ms / full_draw_ms},
          {"bounds_s", bench.boundsSeconds()}};
}

}  // namespace foreland::lab
