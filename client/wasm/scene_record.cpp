#include "client/wasm/scene_record.h"

#include <algorithm>
#include <limits>

#include "client/wasm/conversions.h"

namespace foreland::client {
namespace {

constexpr double kDegreesPerRadian = 57.29577951308232;

// Corners and centres of the root squares that lie inside the data: the only relief known before the first keyframe.
void collectLandmarks(const proto::Welcome& welcome, const proto::FrameTransform& transform, std::vector<double>& out) {
  const auto& shape = welcome.shape;
  const double size = static_cast<double>(1u << shape.root_log2), step = welcome.frame.height_quantum_m;
  const auto add = [&](double x, double y, int32_t height) {
    if (x > shape.samples_x - 1.0 || y > shape.samples_y - 1.0) return;
    const glm::dvec3 p = transform.toScene(proto::LatticePosition{x, y, height * step});
    out.insert(out.end(), {p.x, p.y, p.z});
  };
  for (uint32_t j = 0; j <= shape.roots_y; ++j)
    for (uint32_t i = 0; i <= shape.roots_x; ++i)
      add(i * size, j * size, welcome.corner_heights[j * (shape.roots_x + 1) + i]);
  for (uint32_t j = 0; j < shape.roots_y; ++j)
    for (uint32_t i = 0; i < shape.roots_x; ++i)
      add((i + 0.5) * size, (j + 0.5) * size, welcome.centre_heights[j * shape.roots_x + i]);
}

// Box around the data, from a net of lattice positions at both extreme heights.
void fillBox(const proto::Welcome& welcome, const proto::FrameTransform& transform, WelcomeRecord& out) {
  constexpr int kCells = 8;
  for (int axis = 0; axis < 3; ++axis) {
    out.low[axis] = std::numeric_limits<double>::infinity();
    out.high[axis] = -out.low[axis];
  }
  for (int k = 0; k <= kCells; ++k)
    for (int l = 0; l <= kCells; ++l)
      for (double height : {out.lowest_m, out.highest_m}) {
        const glm::dvec3 p = transform.toScene(proto::LatticePosition{
            (welcome.shape.samples_x - 1.0) * k / kCells, (welcome.shape.samples_y - 1.0) * l / kCells, height});
        for (int axis = 0; axis < 3; ++axis) {
          out.low[axis] = std::min(out.low[axis], p[axis]);
          out.high[axis] = std::max(out.high[axis], p[axis]);
        }
      }
}

}  // namespace

const WelcomeRecord* SceneRecord::fill(const proto::Welcome& from, const proto::FrameTransform& transform) {
  WelcomeRecord& out = record_;
  out.lowest_m = from.lowest * from.frame.height_quantum_m;
  out.highest_m = from.highest * from.frame.height_quantum_m;
  out.tau_px = from.tau_px;
  out.keyframe_ms = from.keyframe_interval.toMilliseconds();
  out.scene_id[0] = static_cast<uint32_t>(from.scene_id);
  out.scene_id[1] = static_cast<uint32_t>(from.scene_id >> 32);
  out.title = addressOf(from.title.data());
  out.title_size = static_cast<uint32_t>(from.title.size());
  out.crs = addressOf(from.crs.data());
  out.crs_size = static_cast<uint32_t>(from.crs.size());
  out.is_geographic = from.frame.kind == proto::FrameKind::kGeographic ? 1 : 0;
  out.samples_x = from.shape.samples_x;
  out.samples_y = from.shape.samples_y;
  fillBox(from, transform, out);
  landmarks_.clear();
  collectLandmarks(from, transform, landmarks_);
  out.landmark_count = static_cast<uint32_t>(landmarks_.size() / 3);
  out.landmarks = addressOf(landmarks_.data());
  epochs_ms_.clear();
  for (const proto::Epoch& epoch : from.epochs) epochs_ms_.push_back(millisecondsOf(epoch.time));
  out.epoch_count = static_cast<uint32_t>(epochs_ms_.size());
  out.epochs = addressOf(epochs_ms_.data());
  out.max_moved_m = from.max_offset * from.frame.height_quantum_m;
  const proto::VerticalDatum& vertical = from.vertical;
  out.zero_surface = static_cast<uint32_t>(vertical.zero_surface);
  out.undulation_error_m = vertical.undulations.max_error_m;
  out.datum = addressOf(vertical.name.data());
  out.datum_size = static_cast<uint32_t>(vertical.name.size());
  out.geoid = addressOf(vertical.geoid.data());
  out.geoid_size = static_cast<uint32_t>(vertical.geoid.size());
  model_sides_.clear();
  for (const proto::ObjectModel& model : from.models) model_sides_.push_back(model.atlas_side);
  out.model_count = static_cast<uint32_t>(model_sides_.size());
  out.model_sides = addressOf(model_sides_.data());
  return &out;
}

MapPositionRecord mapPositionOf(const proto::FrameTransform& transform, const glm::dvec3& point, double ground_m) {
  const glm::dvec3 up = transform.upAt(point);
  MapPositionRecord out{};
  const proto::LatticePosition lattice = transform.toLattice(point);
  out.height_m = lattice.height_m;
  out.lattice[0] = lattice.x;
  out.lattice[1] = lattice.y;
  out.ground_m = ground_m;
  out.up[0] = up.x;
  out.up[1] = up.y;
  out.up[2] = up.z;
  if (transform.frame().kind == proto::FrameKind::kGeographic) {
    const proto::Geodetic geodetic = transform.toGeodetic(point);
    out.across[0] = geodetic.latitude_rad * kDegreesPerRadian;
    out.across[1] = geodetic.longitude_rad * kDegreesPerRadian;
  } else {
    out.across[0] = transform.frame().map_origin_m.y + point.y;
    out.across[1] = transform.frame().map_origin_m.x + point.x;
  }
  return out;
}

glm::dvec3 scenePointOf(const proto::FrameTransform& transform, glm::dvec2 across, double height_m) {
  const proto::Frame& frame = transform.frame();
  if (frame.kind == proto::FrameKind::kPlanar)
    return {across[1] - frame.map_origin_m.x, across[0] - frame.map_origin_m.y, height_m};
  return transform.toScene(proto::Geodetic{.latitude_rad = across[0] / kDegreesPerRadian,
                                           .longitude_rad = across[1] / kDegreesPerRadian,
                                           .height_m = height_m});
}

SlopeFrameRecord slopeFrameOf(const proto::Frame& frame) {
  SlopeFrameRecord out{};
  out.is_geographic = frame.kind == proto::FrameKind::kGeographic ? 1 : 0;
  const glm::dvec2 &x = frame.axis_x_m, &y = frame.axis_y_m;
  const double area = x.x * y.y - x.y * y.x;
  out.gradient_x[0] = y.y / area, out.gradient_x[1] = -y.x / area;
  out.gradient_y[0] = -x.y / area, out.gradient_y[1] = x.x / area;
  out.latitude = frame.latitude0_rad;
  out.longitude = frame.longitude0_rad - frame.origin.longitude_rad;
  out.latitude_step = frame.latitude_step_rad;
  out.longitude_step = frame.longitude_step_rad;
  out.origin_latitude = frame.origin.latitude_rad;
  out.semi_major_m = frame.semi_major_m;
  out.eccentricity_squared = frame.flattening * (2 - frame.flattening);
  return out;
}

LayerRecord recordOf(const proto::TileLayer& layer) {
  LayerRecord out{};
  out.origin[0] = layer.origin.x, out.origin[1] = layer.origin.y;
  out.texel = layer.texel;
  out.size[0] = layer.width, out.size[1] = layer.height;
  out.levels = layer.levels();
  out.attribution = addressOf(layer.attribution.data());
  out.attribution_size = static_cast<uint32_t>(layer.attribution.size());
  return out;
}

}  // namespace foreland::client
