#include "apps/viewshed/viewshed_options.h"

#include <cmath>

#include "apps/options/options.h"
#include "apps/options/place.h"

namespace foreland::apps {

void addViewshedOptions(CLI::App& app, ViewshedOptions& o, const std::string& group) {
  const auto add = [&](const char* name, auto& value, const char* what) {
    return app.add_option(name, value, what)->group(group)->capture_default_str();
  };
  add("--radius", o.question.radius_m, "how far to look, in metres across the ground")
      ->type_name(number("M"))
      ->check(within(0.001, server::Viewshed::kMaxRadius_m));
  add("--target", o.question.target_m, "height above the ground of what is looked at, in metres")
      ->type_name(number("M"))
      ->check(within(0.0, server::Viewshed::kMaxHeight_m));
  add("--refraction", o.question.refraction,
      "coefficient of refraction of the air, by which light bends around the earth: 0 for straight lines, 1/7 as usual")
      ->type_name(number("K"))
      ->check(within(0.0, server::Viewshed::kMaxRefraction));
}

Result<server::ViewshedQuestion> questionOf(const ViewshedOptions& o, const std::string& option,
                                            const terrain::Scene& scene) {
  const auto refused = [&](const std::string& why) {
    return Error{ErrorCode::kInvalidArgument, option + " '" + o.from.value_or("") + "': " + why};
  };
  const auto numbers = numbersOf(o.from.value_or(""));
  const bool is_planar = scene.frame().kind == proto::FrameKind::kPlanar;
  if (!numbers || numbers->size() != 3)
    return refused("write LAT,LON,HEIGHT in degrees and metres (x and y of a planar scene's map)");
  const std::vector<double>& n = *numbers;
  if (!is_planar && (std::fabs(n[0]) > 90 || std::fabs(n[1]) > 360))
    return refused("the scene is geographic: latitude and longitude in degrees come first");
  if (n[2] < 0) return refused("lies under the ground; HEIGHT is metres above it");
  const proto::LatticePosition at = latticeOf(proto::FrameTransform(scene.frame()), n[0], n[1]);
  const proto::GridShape& shape = scene.grid().shape();
  if (!(at.x >= 0 && at.y >= 0 && at.x <= shape.samples_x - 1 && at.y <= shape.samples_y - 1))
    return refused(std::string("lies beyond the data; `foreland info` tells where that is, ") +
                   (is_planar ? "x and y are the map's, in metres" : "latitude and longitude are degrees"));
  server::ViewshedQuestion question = o.question;
  question.observer = {at.x, at.y};
  question.observer_m = n[2];
  return question;
}

}  // namespace foreland::apps
