#include "terrain/geoid/earth_positions.h"

#include <cmath>
#include <limits>

#include "terrain/geoid/proj_context.h"

namespace foreland::terrain {

struct EarthPositions::Parts {
  ProjContext context;
  ProjObject to_degrees;
};

EarthPositions::EarthPositions(std::unique_ptr<Parts> parts) : parts_(std::move(parts)) {}
EarthPositions::~EarthPositions() = default;

Result<std::shared_ptr<EarthPositions>> EarthPositions::of(const std::string& wkt) {
  auto parts = std::make_unique<Parts>();
  parts->context = newProjContext();
  PJ_CONTEXT* context = parts->context.get();
  const ProjObject stated(proj_create(context, wkt.c_str()));
  const char* name = stated ? proj_get_name(stated.get()) : "it";
  const std::string refusal =
      std::string("its reference system (") + name + ") has no transformation to WGS84, so no geoid is known over it";
  const bool is_compound = stated && proj_get_type(stated.get()) == PJ_TYPE_COMPOUND_CRS;
  const ProjObject part(is_compound ? proj_crs_get_sub_crs(context, stated.get(), 0) : nullptr);
  const ProjObject flat(part || stated ? proj_crs_demote_to_2D(context, nullptr, part ? part.get() : stated.get())
                                       : nullptr);
  const ProjObject wgs84(proj_create(context, "EPSG:4326"));
  const ProjObject way(
      flat && wgs84 ? proj_create_crs_to_crs_from_pj(context, flat.get(), wgs84.get(), nullptr, nullptr) : nullptr);
  if (way) parts->to_degrees.reset(proj_normalize_for_visualization(context, way.get()));
  if (!parts->to_degrees) return Error{ErrorCode::kUnsupported, refusal};
  return std::shared_ptr<EarthPositions>(new EarthPositions(std::move(parts)));
}

void EarthPositions::toDegrees(std::span<glm::dvec2> positions) const {
  if (positions.empty()) return;
  proj_trans_generic(parts_->to_degrees.get(), PJ_FWD, &positions[0].x, sizeof(glm::dvec2), positions.size(),
                     &positions[0].y, sizeof(glm::dvec2), positions.size(), nullptr, 0, 0, nullptr, 0, 0);
  for (glm::dvec2& p : positions)
    if (!std::isfinite(p.x) || !std::isfinite(p.y)) p = glm::dvec2(std::numeric_limits<double>::quiet_NaN());
}

}  // namespace foreland::terrain
