#include "server/view/tour.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/geometric.hpp>
#include <limits>
#include <numbers>
#include <optional>

#include "base/printable.h"
#include "server/view/globe_tour.h"
#include "server/view/ground.h"
#include "server/view/pace.h"
#include "terrain/store/flat_squares.h"

namespace foreland::server {

namespace {

constexpr double kPi = std::numbers::pi;
constexpr Duration kStep = Duration::milliseconds(100);
constexpr double kFarthest_rad = 0.5;     // from the middle of a geographic scene: beyond, its plane is no map of it
constexpr double kWidestSpacing_m = 100;  // of samples that tours are meant for
constexpr double kFall_m = 3000;          // within which a tour slows down for fine ground

double radians(double degrees) { return degrees * kPi / 180; }

// The scene as the planners of tours need it: a rectangle of ground around the middle of the data, in metres of the
// plane that touches the earth there.
class Ground {
 public:
  explicit Ground(const terrain::Scene& scene) : scene_(scene), transform_(scene.frame()) {
    const proto::GridShape& shape = scene.grid().shape();
    last_x_ = shape.samples_x - 1;
    last_y_ = shape.samples_y - 1;
    const proto::Frame& frame = transform_.frame();
    double reach_x = last_x_ / 2, reach_y = last_y_ / 2;
    if (frame.kind == proto::FrameKind::kGeographic) {
      reach_x = std::min(reach_x, kFarthest_rad / frame.longitude_step_rad);
      reach_y = std::min(reach_y, kFarthest_rad / frame.latitude_step_rad);
    }
    const auto at = [&](double x, double y) { return transform_.toScene(proto::LatticePosition{x, y, 0}); };
    const glm::dvec3 middle = at(last_x_ / 2, last_y_ / 2);
    middle_ = middle;
    axis_x_ = glm::dvec2(at(last_x_ / 2 + reach_x, last_y_ / 2) - middle);
    axis_y_ = glm::dvec2(at(last_x_ / 2, last_y_ / 2 + reach_y) - middle);
    const glm::dvec2 step_m(halfWidth() / reach_x, halfDepth() / reach_y);
    // Of samples that are there everywhere.
    const double spacing_m = std::ldexp(std::max(step_m.x, step_m.y), static_cast<int>(shape.sparse_levels / 2));
    scale_ = std::min(std::max(1.0, spacing_m / kWidestSpacing_m), 2 * std::min(halfWidth(), halfDepth()) / 6000);
    if (scene.isSparse()) pace_.emplace(scene, step_m, kFall_m * scale_);
  }

  glm::dvec2 middle() const { return middle_; }
  double halfWidth() const { return glm::length(axis_x_); }
  double halfDepth() const { return glm::length(axis_y_); }
  // Unit vectors along the raster.
  glm::dvec2 alongX() const { return glm::normalize(axis_x_); }
  glm::dvec2 alongY() const { return glm::normalize(axis_y_); }
  // The factor by which a tour's distances shrink on small scenes, and grow on coarse ones.
  double scale() const { return scale_; }
  // The share of a tour's speed and height that it has above a point of the tangent plane.
  double pace(glm::dvec2 p) const {
    if (!pace_) return 1;
    const proto::LatticePosition at = below(p);
    return pace_->at({at.x, at.y});
  }

  // The lattice position, with the ground's height, below a point of the tangent plane; clamped to the data.
  proto::LatticePosition below(glm::dvec2 p) const {
    // A point of the plane lies above the curved ground, and how far shifts its lattice position: two iterations.
    proto::LatticePosition position = transform_.toLattice({p, 0});
    for (int i = 0; i < 2 && transform_.frame().kind == proto::FrameKind::kGeographic; ++i) {
      position.height_m = 0;
      position = transform_.toLattice({p, transform_.toScene(position).z});
    }
    position.x = std::clamp(position.x, 0.0, last_x_);
    position.y = std::clamp(position.y, 0.0, last_y_);
    position.height_m = groundHeight(scene_, position.x, position.y).value_or(0);
    return position;
  }
  double height(glm::dvec2 p) const { return below(p).height_m; }
  // At least that of all ground from one point to another.
  double highestBetween(glm::dvec2 from, glm::dvec2 to) const {
    const proto::LatticePosition a = below(from), b = below(to);
    const auto [west, east] = std::minmax(a.x, b.x);
    const auto [south, north] = std::minmax(a.y, b.y);
    double highest = std::max(a.height_m, b.height_m);
    if (scene_.isSparse()) return std::max(highest, highestCorner({west, south}, {east, north}));
    for (auto y = std::floor(south); y <= std::min(std::ceil(north), last_y_); ++y)
      for (auto x = std::floor(west); x <= std::min(std::ceil(east), last_x_); ++x)
        highest = std::max(highest, groundHeight(scene_, x, y).value_or(0));
    return highest;
  }
  bool contains(glm::dvec2 p, double margin) const {
    const glm::dvec2 d = p - middle_;
    return std::fabs(glm::dot(d, alongX())) < halfWidth() - margin &&
           std::fabs(glm::dot(d, alongY())) < halfDepth() - margin;
  }
  glm::dvec3 above(glm::dvec2 p, double height_m) const {
    proto::LatticePosition position = below(p);
    position.height_m = height_m;
    return transform_.toScene(position);
  }
  glm::dvec3 upAt(const glm::dvec3& p) const { return transform_.upAt(p); }

 private:
  // Of the squares around a window of the lattice, in which ground that is fine in places is even.
  double highestCorner(glm::dvec2 low, glm::dvec2 high) const {
    const auto at = [](double v) { return static_cast<uint32_t>(v); };
    double highest = std::numeric_limits<double>::lowest();
    terrain::FlatSquares(scene_.grid(), scene_.pages())
        .forEachIn(at(std::floor(low.x)), at(std::floor(low.y)), at(std::ceil(high.x)), at(std::ceil(high.y)),
                   [&](uint32_t x, uint32_t y, uint32_t side) {
                     for (const glm::dvec2 corner : {glm::dvec2(x, y), glm::dvec2(x + side, y), glm::dvec2(x, y + side),
                                                     glm::dvec2(x + side, y + side)})
                       highest = std::max(highest, groundHeight(scene_, corner.x, corner.y).value_or(0));
                   });
    return highest;
  }

  const terrain::Scene& scene_;
  proto::FrameTransform transform_;
  double last_x_, last_y_;
  glm::dvec2 middle_, axis_x_, axis_y_;
  double scale_ = 1;
  std::optional<Pace> pace_;  // of ground that is fine in places
};

// Along the ground below the eye, but for the pitch.
proto::Pose look(const Ground& ground, const glm::dvec3& eye, glm::dvec2 heading, double pitch_rad) {
  const glm::dvec3 up = ground.upAt(eye), ahead(heading, 0);
  const glm::dvec3 level = glm::normalize(ahead - glm::dot(ahead, up) * up);
  return {eye, proto::lookAlong(level * std::cos(pitch_rad) + up * std::sin(pitch_rad), up)};
}

// The highest ground within two steps of each point of a track: what a path through these points may pass over.
std::vector<double> highestNear(const Ground& ground, const std::vector<glm::dvec2>& track) {
  std::vector<double> step(track.size() - 1), near(track.size());
  for (size_t i = 0; i < step.size(); ++i) step[i] = ground.highestBetween(track[i], track[i + 1]);
  for (size_t i = 0; i < track.size(); ++i)
    near[i] = *std::max_element(&step[i > 2 ? i - 2 : 0], &step[std::min(i + 1, step.size() - 1)] + 1);
  return near;
}

// The heights at which to fly along a track: the highest ground within `reach` samples, smoothed twice by a mean over
// as many, never below the ground itself, plus the clearance; and a quarter of it above all that is near. The clearance
// is that of places where the pace is 1.
std::vector<double> flightLevels(const Ground& ground, const std::vector<glm::dvec2>& track, size_t reach,
                                 double clearance_m) {
  const size_t n = track.size();
  std::vector<double> level(n), other(n);
  for (size_t i = 0; i < n; ++i) level[i] = ground.height(track[i]);
  const auto windowed = [&](auto&& combine) {
    for (size_t i = 0; i < n; ++i) other[i] = combine(i > reach ? i - reach : 0, std::min(i + reach, n - 1));
    level.swap(other);
  };
  const std::vector<double> lowest_allowed = level;
  windowed([&](size_t a, size_t b) { return *std::max_element(&level[a], &level[b] + 1); });
  const auto mean = [&](size_t a, size_t b) {
    double sum = 0;
    for (size_t i = a; i <= b; ++i) sum += level[i];
    return sum / static_cast<double>(b - a + 1);
  };
  windowed(mean);
  windowed(mean);
  const std::vector<double> near = highestNear(ground, track);
  for (size_t i = 0; i < n; ++i) {
    const double above_m = clearance_m * ground.pace(track[i]);
    level[i] = std::max(std::max(level[i], lowest_allowed[i]) + above_m, near[i] + above_m / 4);
  }
  return level;
}

proto::Path alongTrack(const Ground& ground, const std::vector<glm::dvec2>& track, const std::vector<double>& levels,
                       double pitch_rad) {
  proto::Path path{Time{}, kStep, {}};
  for (size_t i = 0; i < track.size(); ++i) {
    // The heading is that over a second of flight, so that the camera does not twitch.
    const size_t a = i > 5 ? i - 5 : 0, b = std::min(i + 5, track.size() - 1);
    path.poses.push_back(look(ground, ground.above(track[i], levels[i]), track[b] - track[a], pitch_rad));
  }
  return path;
}

// A racetrack along the longer side: straight legs joined by half circles.
proto::Path survey(const Ground& ground, size_t steps) {
  const double speed = 150 * ground.scale(), step_m = speed * kStep.toSeconds();
  const bool wide = ground.halfWidth() > ground.halfDepth();
  const glm::dvec2 along = wide ? ground.alongX() : ground.alongY(), across = wide ? -ground.alongY() : ground.alongX();
  const double half = 0.86 * std::max(ground.halfWidth(), ground.halfDepth());
  const double radius = std::min(1200 * ground.scale(), 0.4 * std::min(ground.halfWidth(), ground.halfDepth()));
  const double leg = 2 * (half - radius), bend = kPi * radius;
  std::vector<glm::dvec2> track;
  double gone = 0;  // steps
  for (size_t i = 0; i < steps; ++i) {
    const double s = std::fmod(gone * step_m, 2 * (leg + bend));
    const bool back = s >= leg + bend;
    const double t = back ? s - leg - bend : s, turn = std::max(0.0, t - leg) / radius;
    glm::dvec2 q(std::min(t, leg) - leg / 2 + radius * std::sin(turn),
                 -radius * std::cos(turn));  // right half of the racetrack
    if (back) q = -q;
    track.push_back(ground.middle() + along * q.x + across * q.y);
    gone += ground.pace(track.back());
  }
  return alongTrack(ground, track, flightLevels(ground, track, 15, 300 * ground.scale()), radians(-12));
}

// Turns, at no more than 12 degrees a second, to where the ground ahead is lowest, and away from the border.
proto::Path canyon(const Ground& ground, size_t steps) {
  const double scale = ground.scale(), step_m = 80 * scale * kStep.toSeconds(), rate = radians(12) * kStep.toSeconds();
  const auto cost = [&](glm::dvec2 from, double heading) {
    double sum = 0;
    const double pace = ground.pace(from);
    for (double reach : {200.0, 400.0, 700.0, 1100.0, 1600.0}) {
      const glm::dvec2 p = from + reach * scale * pace * glm::dvec2(std::cos(heading), std::sin(heading));
      sum += ground.height(p) + (ground.contains(p, 300 * scale) ? 0 : 3000 * scale);
    }
    return sum;
  };
  glm::dvec2 at = ground.middle();
  double heading = 0, best = 1e300;
  for (double h = 0; h < 2 * kPi; h += radians(10))
    if (const double c = cost(at, h); c < best) best = c, heading = h;
  std::vector<glm::dvec2> track;
  double wanted = heading;
  for (size_t i = 0; i < steps; ++i) {
    if (i % 5 == 0) {  // twice a second
      best = 1e300;
      for (int k = -8; k <= 8; ++k) {
        const double h = heading + radians(7.5 * k), c = cost(at, h) + 4 * scale * k * k;
        if (c < best) best = c, wanted = h;
      }
    }
    heading += std::clamp(wanted - heading, -rate, rate);
    at += step_m * ground.pace(at) * glm::dvec2(std::cos(heading), std::sin(heading));
    track.push_back(at);
  }
  return alongTrack(ground, track, flightLevels(ground, track, 6, 60 * scale), radians(-4));
}

proto::Path spin(const Ground& ground, size_t steps) {
  proto::Path path{Time{}, kStep, {}};
  const glm::dvec3 eye = ground.above(
      ground.middle(), ground.height(ground.middle()) + 150 * ground.scale() * ground.pace(ground.middle()));
  for (size_t i = 0; i < steps; ++i) {
    const double heading = radians(90) * static_cast<double>(i) * kStep.toSeconds();
    path.poses.push_back(look(ground, eye, {std::cos(heading), std::sin(heading)}, radians(-5)));
  }
  return path;
}

proto::Path orbit(const Ground& ground, size_t steps) {
  glm::dvec2 summit = ground.middle();
  double top = -1e300;
  for (int i = -20; i <= 20; ++i)
    for (int j = -20; j <= 20; ++j) {
      const glm::dvec2 p = ground.middle() + ground.alongX() * (ground.halfWidth() * i / 40.0) +
                           ground.alongY() * (ground.halfDepth() * j / 40.0);
      if (const double h = ground.height(p); h > top) top = h, summit = p;
    }
  const double scale = ground.scale() * ground.pace(summit), radius = 2500 * scale;
  double highest = top;
  const auto onCircle = [&](double angle) { return summit + radius * glm::dvec2(std::cos(angle), std::sin(angle)); };
  for (int i = 0; i < 72; ++i) highest = std::max(highest, ground.height(onCircle(radians(5 * i))));
  std::vector<glm::dvec2> track;
  for (size_t i = 0; i < steps; ++i)
    track.push_back(onCircle(radians(6) * static_cast<double>(i) * kStep.toSeconds()));  // once a minute
  const std::vector<double> near = highestNear(ground, track);
  const double level = std::max(highest + 500 * scale, *std::max_element(near.begin(), near.end()) + 125 * scale);
  const glm::dvec3 target = ground.above(summit, top);
  proto::Path path{Time{}, kStep, {}};
  for (const glm::dvec2& p : track) {
    const glm::dvec3 eye = ground.above(p, level);
    path.poses.push_back({eye, proto::lookAlong(target - eye, ground.upAt(eye))});
  }
  return path;
}

struct Tour {
  const char* name;
  proto::Path (*plan)(const Ground&, size_t);
};
constexpr std::array<Tour, 4> kTours{{{"survey", survey}, {"canyon", canyon}, {"spin", spin}, {"orbit", orbit}}};

}  // namespace

Status checkTour(const terrain::Scene& scene, const std::string& name) {
  if (std::any_of(kTours.begin(), kTours.end(), [&](const Tour& tour) { return name == tour.name; })) return {};
  const std::optional<Status> over_globe = checkGlobeTour(name);
  if (scene.grid().isCube() && over_globe) return *over_globe;
  return Error{ErrorCode::kNotFound,
               "there is no tour '" + printable(name, 40) + "'" + (over_globe ? " but over globes" : "") +
                   "; choose survey, canyon, spin or orbit" +
                   (scene.grid().isCube() ? ", descent, pole, antimeridian, corner or equator" : "")};
}

Result<proto::Path> planTour(const terrain::Scene& scene, const std::string& name, double seconds) {
  if (Status known = checkTour(scene, name); !known.ok()) return known.error();
  const size_t steps = static_cast<size_t>(std::clamp(seconds, 1.0, 3600.0) / kStep.toSeconds()) + 2;
  if (scene.grid().isCube()) return planGlobeTour(scene, name, steps, kStep);
  const Ground ground(scene);
  return std::find_if(kTours.begin(), kTours.end(), [&](const Tour& tour) { return name == tour.name; })
      ->plan(ground, steps);
}

}  // namespace foreland::server
