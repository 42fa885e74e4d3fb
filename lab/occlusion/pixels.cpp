#include "lab/occlusion/pixels.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <limits>
#include <vector>

#include "oracle/drawn_surface.h"
#include "terrain/parallel.h"
#include "terrain/render/projector.h"

namespace foreland::lab {

namespace {

using terrain::ParameterLookup;
using terrain::Projector;
using terrain::Ray;
using terrain::RayCaster;
using terrain::RayHit;

constexpr double kRounding_px = 1e-3;  // of positions in floats

// In pixels; infinite if there is no second point, or if it lies behind the eye.
double screenDistance(const Projector& projector, const glm::dvec3& a, const std::optional<glm::dvec3>& b) {
  if (!b || projector.depth(*b) <= 0) return std::numeric_limits<double>::infinity();
  return projector.screenDistance(a, *b);
}

// What is drawn, for both ways of looking at it.
struct Drawn {
  RayCaster caster;
  ParameterLookup lookup;

  static Result<Drawn> of(const client::KeyframeMesh& mesh, double weight) {
    auto caster = RayCaster::ofSurface(oracle::drawnSurface(mesh, weight));
    if (!caster) return caster.error();
    auto lookup = ParameterLookup::of(oracle::drawnSurface(mesh, weight));
    if (!lookup) return lookup.error();
    return Drawn{std::move(*caster), std::move(*lookup)};
  }
};

class Judgement {
 public:
  Judgement(const RayCaster& truth, const oracle::LineOfSight& terrain, const Drawn& with, const Drawn& without,
            const Projector& projector, double tau_px, std::span<const uint8_t> hidden_objects)
      : hidden_objects_(hidden_objects),
        truth_(truth),
        terrain_(terrain),
        with_(with),
        without_(without),
        projector_(projector),
        max_px_(tau_px + kRounding_px) {}

  void look(const Ray& ray, PixelCounts& counts) const {
    ++counts.pixels;
    judgeTruePoint(ray, counts);
    const bool is_over = drawnError(with_, ray) > max_px_;
    counts.drawn_over_tau_hidden += is_over && !(drawnError(without_, ray) > max_px_) ? 1 : 0;
  }

 private:
  void judgeTruePoint(const Ray& ray, PixelCounts& counts) const {
    const std::optional<RayHit> hit = truth_.hit(ray);
    if (hit && hit->object != RayHit::kTerrain && hidden_objects_[static_cast<size_t>(hit->object)] != 0)
      ++counts.hidden_objects_seen;
    if (!hit || hit->object != RayHit::kTerrain) return;
    const double with_px = screenDistance(projector_, hit->position, with_.lookup.at(*hit)),
                 without_px = screenDistance(projector_, hit->position, without_.lookup.at(*hit));
    const bool is_over = with_px > max_px_, is_over_without = without_px > max_px_;
    if (std::isfinite(with_px)) counts.max_px = std::max(counts.max_px, with_px);
    counts.visible_over_tau += is_over ? 1 : 0;
    counts.visible_over_tau_without += is_over_without ? 1 : 0;
    counts.visible_over_tau_hidden += is_over && !is_over_without ? 1 : 0;
  }

  double drawnError(const Drawn& drawn, const Ray& ray) const {
    const std::optional<RayHit> hit = drawn.caster.hit(ray);
    if (!hit || hit->object != RayHit::kTerrain) return 0;
    return screenDistance(projector_, hit->position, terrain_.pointAt(hit->parameter));
  }

  std::span<const uint8_t> hidden_objects_;
  const RayCaster& truth_;
  const oracle::LineOfSight& terrain_;
  const Drawn &with_, &without_;
  const Projector& projector_;
  double max_px_;
};

}  // namespace

void PixelCounts::add(const PixelCounts& other) {
  pixels += other.pixels;
  hidden_objects_seen += other.hidden_objects_seen;
  visible_over_tau += other.visible_over_tau;
  visible_over_tau_without += other.visible_over_tau_without;
  visible_over_tau_hidden += other.visible_over_tau_hidden;
  drawn_over_tau_hidden += other.drawn_over_tau_hidden;
  max_px = std::max(max_px, other.max_px);
}

Result<PixelCounts> PixelJudge::judge(const DrawnPair& drawn, const terrain::Camera& camera, double tau_px) const {
  const auto with = Drawn::of(drawn.with, drawn.weight), without = Drawn::of(drawn.without, drawn.weight);
  for (const auto* side : {&with, &without})
    if (!*side) return side->error();
  const Projector projector(camera);
  const Judgement judgement(truth_, terrain_, *with, *without, projector, tau_px, drawn.hidden_objects);
  std::vector<PixelCounts> rows(camera.lens.height_px);
  terrain::parallelFor(
      rows.size(), camera.threads,
      [&](uint64_t row, unsigned) {
        for (uint32_t column = 0; column < camera.lens.width_px; ++column)
          judgement.look(projector.through(column, static_cast<uint32_t>(row)), rows[row]);
      },
      [](uint64_t) { return true; });
  PixelCounts all;
  for (const PixelCounts& row : rows) all.add(row);
  return all;
}

}  // namespace foreland::lab
