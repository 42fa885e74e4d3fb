#include "proto/imagery/tile_selection.h"

#include <algorithm>
#include <cmath>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <numbers>

#include "base/sort.h"
#include "proto/refine/metric/frustum.h"

namespace foreland::proto {

namespace {

// Level ground that is seen at a grazing angle counts as if it were seen at one of three degrees.
constexpr double kMinFacing = 0.05;
// Slopes over 60 degrees count as such: a texel there is no larger.
constexpr double kMaxFacing = 2;
constexpr double kMaxBend = 0.1;
constexpr double kWithinFace = 1e-6;  // lattice steps
constexpr double kQuarterTurn = 1.57079632679489662;

class Selection {
 public:
  Selection(const TileLayer& layer, const FrameTransform& frame, const View& view)
      : layer_(layer),
        frame_(frame),
        view_(view),
        frustum_(view, kNearestGround_m),
        eye_(frame.toLattice(view.pose.eye)) {
    focal_px_ = view.lens.height_px / (2 * view.lens.tanHalfFov());
    cos_region_ = std::cos(view.region_angle_rad), sin_region_ = std::sin(view.region_angle_rad);
    largest_stretch_ = stretchAt(frustum_.cosCorner());
    if (frame.frame().kind == FrameKind::kGlobe) eye_normal_ = frame.upAt(view.pose.eye);
    if (frame.frame().kind == FrameKind::kPlanar)
      planar_axes_ = axesAt({0, 0, 0}, frame.toScene(LatticePosition{0, 0, 0}));
  }

  // Unit vectors along the lattice at a point, and up; metres between samples.
  struct Axes {
    glm::dvec3 x{0}, y{0}, up{0};
    glm::dvec2 spacing{0};
  };

  // Some of a tile's ground as the view has it.
  struct Ground {
    Ground(const Selection& selection, const LatticeBox& lattice_box, double lowest, double highest)
        : box(lattice_box), lowest_m(lowest), highest_m(highest) {
      // The side of a face is the next face's, which need not lie beside it.
      if (selection.frame_.frame().kind == FrameKind::kGlobe) box.high.x -= kWithinFace;
      const glm::dvec2 middle = 0.5 * (box.low + box.high);
      const LatticePosition at{middle.x, middle.y, 0.5 * (lowest + highest)};
      const FrameTransform& frame = selection.frame_;
      centre = frame.toScene(at);
      axes = selection.planar_axes_ ? *selection.planar_axes_ : selection.axesAt(at, centre);
      double square = 0;
      for (const double x : {box.low.x, box.high.x})
        for (const double y : {box.low.y, box.high.y}) {
          const auto include = [&](double height) {
            const glm::dvec3 d = frame.toScene(LatticePosition{x, y, height}) - centre;
            square = std::max(square, glm::dot(d, d));
          };
          include(lowest);
          // In a plane frame the others are opposite to these.
          if (!selection.planar_axes_) include(highest);
        }
      radius = std::sqrt(square) + selection.view_.region_radius_m;
      level_spacing_px = std::sqrt(axes.spacing.x * selection.widening(box) * axes.spacing.y) * selection.focal_px_ /
                         selection.nearestDistance(*this);
      from_eye = centre - selection.view_.pose.eye;
      distance = glm::length(from_eye);
      in_view = selection.frustum_.toView(from_eye.x, from_eye.y, from_eye.z);
      sin_spread = distance <= radius ? 1 : radius / distance;
      cos_spread = std::sqrt(1 - sin_spread * sin_spread);
    }
    bool isAround() const { return distance <= radius; }

    LatticeBox box;
    double lowest_m, highest_m;
    glm::dvec3 centre{0}, from_eye{0};
    Axes axes;  // at the centre
    // Of a sample interval on the screen, were it level, seen from straight above and in the middle of the screen: the
    // root of its area, at most.
    double level_spacing_px = 0;
    double radius = 0;                      // of all of it about the centre, the eye's region taken into account
    double distance = 0;                    // from the eye to the centre
    double sin_spread = 0, cos_spread = 0;  // of half the angle that it fills; a right angle if the eye may be in it
    ViewPosition in_view{};                 // of the centre
  };

  // The largest size on the screen of a texel of a level on some ground, whose slopes are bounded by those of a tile or
  // of a part; nothing if no part of it can be in view.
  template <class Slopes>
  std::optional<double> texelSize(uint8_t level, const Ground& ground, const Slopes& slopes) const {
    if (!isInView(ground)) return std::nullopt;
    const double facing = largestFacing(slopes, ground);
    if (facing <= 0) return std::nullopt;
    return levelTexelSize(level, ground) * stretch(ground) * std::sqrt(std::clamp(facing, kMinFacing, kMaxFacing));
  }
  // No less than that, and sooner known.
  double maxTexelSize(uint8_t level, const Ground& ground) const {
    return levelTexelSize(level, ground) * largest_stretch_ * std::sqrt(kMaxFacing);
  }

  // Pixels of a part of a tile that the tile makes finer, as SelectedTile counts them.
  // Source: THEORY section 5, "Metric", half the sum of both axes of a texel's image; but texels go on to gain
  // something below a pixel, for a pixel is the mean of what it shows: all from 2 px on, a quarter at 1 px, nothing at
  // half a pixel.
  double finerPixels(uint8_t level, const Ground& ground, const TilePart& part) const {
    if (!(ground.distance > 0) || frustum_.sideDistance(ground.in_view) < 0) return 0;
    const Axes& axes = ground.axes;
    const glm::dvec3 v = -ground.from_eye / ground.distance;
    const double facing = glm::dot(v, axes.up) -
                          0.5 * (part.min_rise_m[0] + part.largest_rise_m[0]) / axes.spacing.x * glm::dot(v, axes.x) -
                          0.5 * (part.min_rise_m[1] + part.largest_rise_m[1]) / axes.spacing.y * glm::dot(v, axes.y);
    if (facing <= 0) return 0;
    const double texel = layer_.texelAt(level);
    const double across_px = std::sqrt(axes.spacing.x * axes.spacing.y) * texel * focal_px_ / ground.distance;
    const auto gain = [](double size_px) { return std::pow(std::clamp(0.5 + 0.5 * std::log2(size_px), 0.0, 1.0), 2); };
    const glm::dvec2 texels = (part.box.high - part.box.low) / texel;
    return texels.x * texels.y * across_px * across_px * facing * 0.5 *
           (gain(2 * across_px) + gain(2 * across_px * facing));
  }

 private:
  Axes axesAt(const LatticePosition& at, const glm::dvec3& scene) const {
    const glm::dvec3 x = frame_.toScene(LatticePosition{at.x + 1, at.y, at.height_m}) - scene,
                     y = frame_.toScene(LatticePosition{at.x, at.y + 1, at.height_m}) - scene,
                     up = frame_.toScene(LatticePosition{at.x, at.y, at.height_m + 1}) - scene;
    const glm::dvec2 spacing(glm::length(x), glm::length(y));
    return {x / spacing.x, y / spacing.y, up, spacing};
  }

  bool isInView(const Ground& g) const { return g.isAround() || frustum_.sideDistance(g.in_view) >= -g.radius; }

  double levelTexelSize(uint8_t level, const Ground& g) const { return g.level_spacing_px * layer_.texelAt(level); }
  // How much farther apart along x samples are where some ground is next to the equator than in its middle, at most.
  double widening(const LatticeBox& box) const {
    if (planar_axes_) return 1;
    const Frame& frame = frame_.frame();
    if (frame.kind == FrameKind::kGlobe) return globeWidening((box.high.x - box.low.x) / frame.face_steps);
    const double south = frame.latitude0_rad + box.low.y * frame.latitude_step_rad,
                 north = frame.latitude0_rad + box.high.y * frame.latitude_step_rad;
    return std::cos(std::clamp(0.0, south, north)) / std::max(1e-9, std::cos(0.5 * (south + north)));
  }
  // The area of a cell changes by less than exp(1.07 s) along s of a face's coordinates, which go from -1 to 1, and is
  // largest in the face's middle; of the share of a face's side that some ground has.
  static double globeWidening(double share) { return std::min(1.46, 1 + 1.25 * share); }
  // From anywhere that the eye may be to the box of the ground.
  double nearestDistance(const Ground& g) const {
    if (frame_.frame().kind == FrameKind::kGlobe)
      return std::max(distanceOnGlobe(g) - view_.region_radius_m, kNearestGround_m);
    const LatticePosition nearest{std::clamp(eye_.x, g.box.low.x, g.box.high.x),
                                  std::clamp(eye_.y, g.box.low.y, g.box.high.y),
                                  std::clamp(eye_.height_m, g.lowest_m, g.highest_m)};
    return std::max(glm::distance(view_.pose.eye, frame_.toScene(nearest)) - view_.region_radius_m, kNearestGround_m);
  }

  // No more than from the eye to the ground of a box. Where a face's coordinates, taken one by one, lead to the nearest
  // of the box it may be nearer somewhere else, for they are skewed: the angle between them is 60 degrees at least.
  double distanceOnGlobe(const Ground& g) const {
    const double beyond = glm::distance(view_.pose.eye, g.centre) - (g.radius - view_.region_radius_m);
    const double steps = frame_.frame().face_steps, face = std::floor(0.5 * (g.box.low.x + g.box.high.x) / steps);
    const auto on_face = cubePointOn(static_cast<uint32_t>(face), eye_normal_);
    if (!on_face) return beyond;
    const glm::dvec2 own((face + 0.5 * (on_face->s + 1)) * steps, 0.5 * (on_face->t + 1) * steps),
        nearest = glm::clamp(own, g.box.low, g.box.high);
    const glm::dvec3 there =
        frame_.toScene(LatticePosition{nearest.x, nearest.y, std::clamp(eye_.height_m, g.lowest_m, g.highest_m)});
    const bool is_below = own == nearest && face == std::floor(eye_.x / steps);
    return std::max(beyond, (is_below ? 1 : 0.8) * glm::distance(view_.pose.eye, there));
  }

  // How much larger the area of a texel appears than if it were level and seen from straight above, at most: for a
  // normal n, (n v) / (n u), v being the direction to the eye and u up. Not more than 0 if all of it faces away.
  double largestFacing(const TileBounds& bounds, const Ground& g) const {
    const glm::dvec3 axis(bounds.axis[0], bounds.axis[1], bounds.axis[2]);
    const double length = glm::length(axis);
    if (length < 1) return kMaxFacing;
    const double half = bounds.half_angle * (kQuarterTurn / 255);
    const double steepest = std::acos(std::clamp(glm::dot(axis, g.axes.up) / length, -1.0, 1.0)) + half;
    const double upright = std::max(1 / kMaxFacing, std::cos(std::min(steepest, kQuarterTurn)));
    if (g.isAround()) return 1 / upright;
    const double away = std::acos(std::clamp(-glm::dot(axis, g.from_eye) / (length * g.distance), -1.0, 1.0));
    return std::cos(std::max(0.0, away - half - std::asin(g.sin_spread))) / upright;
  }

  // The ground's normal is along u - a x - b y where it rises by a along x and by b along y, so that (n v) / (n u) is
  // v u - a (v x) - b (v y): largest at a corner of the eight-sided bounds of (a, b).
  double largestFacing(const TilePart& part, const Ground& g) const {
    const double bend = bendOf(g);
    if (g.isAround() || bend > kMaxBend) return kMaxFacing;
    const Axes& axes = g.axes;
    const glm::dvec3 v = -g.from_eye / g.distance;
    const double a = -glm::dot(v, axes.x) / axes.spacing.x, b = -glm::dot(v, axes.y) / axes.spacing.y;
    const auto most = [&](size_t k, double along) {
      return along * double{along < 0 ? part.min_rise_m[k] : part.largest_rise_m[k]};
    };
    // (a, b) as a sum of multiples of the nearer axis and the nearer diagonal.
    const double diagonal = std::copysign(std::min(std::fabs(a), std::fabs(b)), a);
    const double along_axis =
        std::fabs(a) > std::fabs(b) ? most(0, a - diagonal) : most(1, b - std::copysign(diagonal, b));
    const double along_diagonal = most((a < 0) == (b < 0) ? 2 : 3, diagonal);
    const auto steepest = [&](size_t k) {
      return std::max(std::fabs(part.min_rise_m[k]), std::fabs(part.largest_rise_m[k])) / axes.spacing[int(k)];
    };
    // From elsewhere in the spread v differs, and the bend turns the axes.
    const double slopes = steepest(0) * steepest(0) + steepest(1) * steepest(1);
    const double sin_spread = std::min(1.0, g.sin_spread + bend);
    return g.cos_spread * (glm::dot(v, axes.up) + along_axis + along_diagonal) + sin_spread * std::sqrt(1 + slopes);
  }

  // By how much the directions of the axes, and relatively their lengths, change from the middle of some ground to its
  // corners.
  double bendOf(const Ground& g) const {
    if (planar_axes_) return 0;
    if (frame_.frame().kind == FrameKind::kGlobe) return 3 * g.radius / frame_.frame().minRadius();
    const double x = 0.5 * (g.box.low.x + g.box.high.x), height_m = 0.5 * (g.lowest_m + g.highest_m);
    const auto spacingAt = [&](double y) {
      return glm::distance(frame_.toScene(LatticePosition{x, y, height_m}),
                           frame_.toScene(LatticePosition{x + 1, y, height_m}));
    };
    const double south = spacingAt(g.box.low.y), north = spacingAt(g.box.high.y);
    return g.radius / frame_.frame().minRadius() +
           std::numbers::ln2 * std::fabs(std::log2(std::max(south, 1e-9) / std::max(north, 1e-9)));
  }

  // How much larger things are on a plane screen at an angle from its middle, at the tile's visible point where that is
  // largest: by 1 / cos across the angle and 1 / cos^2 along it, the distance being the same.
  double stretch(const Ground& g) const {
    if (g.isAround()) return largest_stretch_;
    const double cos_middle = std::clamp(g.in_view.z / g.distance, -1.0, 1.0),
                 sin_middle = std::sqrt(1 - cos_middle * cos_middle);
    // The angles' sum, up to a right angle.
    const double cos_edge = cos_middle * g.cos_spread - sin_middle * g.sin_spread,
                 sin_edge = sin_middle * g.cos_spread + cos_middle * g.sin_spread;
    if (cos_edge <= 0) return largest_stretch_;
    const double farthest = cos_edge * cos_region_ - sin_edge * sin_region_;
    return farthest <= frustum_.cosCorner() ? largest_stretch_ : stretchAt(farthest);
  }
  static double stretchAt(double cosine) { return 1 / (cosine * std::sqrt(cosine)); }

  const TileLayer& layer_;
  const FrameTransform& frame_;
  const View& view_;
  Frustum frustum_;
  LatticePosition eye_;
  glm::dvec3 eye_normal_{0};  // on a globe
  double focal_px_;
  double cos_region_ = 1, sin_region_ = 0;  // of the angle that the camera may turn by
  double largest_stretch_;                  // in a corner of the screen
  std::optional<Axes> planar_axes_;         // the same everywhere
};

// The largest texel of a tile on the screen as far as parts of its ground tell.
class PartSearch {
 public:
  PartSearch(const Selection& selection, TileGround& ground) : selection_(selection), ground_(ground) {}

  // Makes `tile.texel_px` smaller if it can, negative if nothing of it is in view, and sets `finer_px`. What is no
  // larger than `enough_px` need not be known more closely.
  void look(SelectedTile& tile, double enough_px) {
    parts_.clear();
    if (!ground_.parts(tile.tile, parts_)) return;
    sized_.clear();
    small_px_ = -1;
    for (const TilePart& part : parts_) {
      const Selection::Ground ground(selection_, part.box, part.lowest_m, part.highest_m);
      if (add(tile.tile.level, ground, part, enough_px))
        tile.finer_px += selection_.finerPixels(tile.tile.level, ground, part);
    }
    double largest_px = small_px_;
    // The largest first: what is left when that cannot be split is no larger.
    while (!sized_.empty()) {
      std::pop_heap(sized_.begin(), sized_.end());
      const Sized next = sized_.back();
      sized_.pop_back();
      parts_.clear();
      if (!ground_.split(next.part, parts_)) {
        largest_px = next.size_px;
        break;
      }
      for (const TilePart& part : parts_)
        add(tile.tile.level, {selection_, part.box, part.lowest_m, part.highest_m}, part, enough_px);
      largest_px = small_px_;
    }
    tile.texel_px = std::min(tile.texel_px, static_cast<float>(largest_px));
  }

 private:
  struct Sized {
    double size_px;
    TilePart part;
    bool operator<(const Sized& other) const { return size_px < other.size_px; }
  };
  // False if the part is small, hidden or out of view.
  bool add(uint8_t level, const Selection::Ground& ground, const TilePart& part, double enough_px) {
    const double max_px = selection_.maxTexelSize(level, ground);
    const auto size_px = max_px <= enough_px ? max_px : selection_.texelSize(level, ground, part);
    if (!size_px) return false;
    if (*size_px <= enough_px) {
      small_px_ = std::max(small_px_, *size_px);
      return false;
    }
    if (ground_.isHidden(part)) return false;
    sized_.push_back({*size_px, part});
    std::push_heap(sized_.begin(), sized_.end());
    return true;
  }

  const Selection& selection_;
  TileGround& ground_;
  std::vector<TilePart> parts_;
  std::vector<Sized> sized_;  // a heap
  double small_px_ = -1;      // the largest of those that are small enough
};

}  // namespace

void selectTiles(const TileLayer& layer, uint8_t layer_index, const FrameTransform& frame, const View& view,
                 double tau_texel_px, size_t most, const TileLookup& lookup, std::vector<SelectedTile>& out,
                 TileGround* ground) {
  out.clear();
  const Selection selection(layer, frame, view);
  std::optional<PartSearch> search;
  if (ground != nullptr) search.emplace(selection, *ground);
  // Within a tile the texels of its parent are twice as large as its own.
  const auto consider = [&](const TileId& tile) {
    if (!layer.has(tile)) return;
    const auto bounds = lookup(tile);
    if (!bounds) return;
    const Selection::Ground area(selection, layer.boxOf(tile), bounds->lowest_m, bounds->highest_m);
    const auto size_px = selection.texelSize(tile.level, area, *bounds);
    SelectedTile selected{tile, static_cast<float>(size_px.value_or(0))};
    // Of a globe's six those that are seen, or all would take room.
    if (layer.isCoarsest(tile) && (size_px || !layer.isGlobe())) return out.push_back(selected);
    if (search && 2 * selected.texel_px > tau_texel_px) search->look(selected, 0.5 * tau_texel_px);
    if (2 * selected.texel_px > tau_texel_px) out.push_back(selected);
  };
  for (uint32_t face = 0; face < layer.faces(); ++face)
    consider({layer_index, static_cast<uint8_t>(layer.levels() - 1), face, 0});
  // Level by level; `from` is the first tile of the level before.
  size_t from = 0;
  while (from < out.size() && out.size() < most && out[from].tile.level > 0) {
    const size_t end = out.size();
    for (size_t i = from; i < end; ++i) {
      const TileId t = out[i].tile;
      for (uint32_t k = 0; k < 4; ++k) consider(t.child(k));
    }
    from = end;
    foreland::sort(out.begin() + static_cast<ptrdiff_t>(from), out.end(),
                   [](const SelectedTile& a, const SelectedTile& b) {
                     return a.texel_px != b.texel_px ? a.texel_px > b.texel_px : a.tile.key() < b.tile.key();
                   });
  }
  if (out.size() > most) out.resize(most);
}

}  // namespace foreland::proto
