#include "terrain/geoid/reference_heights.h"

#include "terrain/geoid/proj_context.h"

namespace foreland::terrain {

HeightStatement heightsOf(const std::string& wkt) {
  if (wkt.empty()) return {};
  const ProjContext context = newProjContext();
  const ProjObject crs(proj_create(context.get(), wkt.c_str()));
  if (!crs) return {};
  if (proj_get_type(crs.get()) == PJ_TYPE_COMPOUND_CRS) {
    const ProjObject vertical(proj_crs_get_sub_crs(context.get(), crs.get(), 1));
    return vertical ? HeightStatement{StatedHeights::kVerticalSystem, proj_get_name(vertical.get())}
                    : HeightStatement{};
  }
  const ProjObject axes(proj_crs_get_coordinate_system(context.get(), crs.get()));
  if (axes && proj_cs_get_axis_count(context.get(), axes.get()) == 3) return {StatedHeights::kEllipsoid, {}};
  return {};
}

}  // namespace foreland::terrain
