#include "client/wasm/scene_record.h"

#include <limits>

#include "client/wasm/conversions.h"

namespace foreland::client {
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
  out.frame_kind = static_cast<uint32_t>(from.frame.kind);
  out.samples_x = from.shape.samples_x;
  out.samples_y = from.shape.samples_y;
  const SceneBox box = boxOf(from, transform);
  for (int axis = 0; axis < 3; ++axis) out.low[axis] = box.low[axis], out.high[axis] = box.high[axis];
  landmarks_.clear();
  for (const glm::dvec3& p : landmarksOf(from, transform)) landmarks_.insert(landmarks_.end(), {p.x, p.y, p.z});
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

MapPositionRecord mapPositionRecordOf(const ScreenPlace& place) {
  constexpr double kUnknown = std::numeric_limits<double>::quiet_NaN();
  const MapPosition& at = place.at;
  return {.height_m = at.height_m,
          .ground_m = place.ground_m.value_or(kUnknown),
          .up = {at.up.x, at.up.y, at.up.z},
          .across = {at.across.x, at.across.y},
          .lattice = {at.lattice.x, at.lattice.y},
          .slope_rad = place.slope_rad.value_or(kUnknown),
          .undulation_m = place.undulation_m.value_or(kUnknown)};
}

SlopeFrameRecord slopeFrameOf(const proto::Frame& frame) {
  SlopeFrameRecord out{};
  out.frame_kind = static_cast<uint32_t>(frame.kind);
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
