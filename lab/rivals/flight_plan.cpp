#include "lab/rivals/flight_plan.h"

#include <vector>

#include "base/bytes.h"
#include "lab/programs/lab_folder.h"
#include "lab/programs/write_file.h"

namespace foreland::lab {

namespace {

constexpr double kDegrees = 57.29577951308232;

Status checkScene(const terrain::Scene& scene) {
  if (scene.frame().kind != proto::FrameKind::kGeographic)
    return Error{ErrorCode::kUnsupported,
                 "the scene is on a map, and the rivals' tiles are cut by longitude and latitude; build it with "
                 "--frame geographic"};
  if (!scene.objectSection().empty() || !scene.epochs().epochs().empty())
    return Error{ErrorCode::kUnsupported,
                 "the scene has objects or moves, which the rivals' tiles do not; use another"};
  return {};
}

Status writeHeights(const terrain::Scene& scene, const std::filesystem::path& file) {
  const proto::GridShape& shape = scene.grid().shape();
  Bytes bytes;
  ByteWriter w(bytes);
  for (uint32_t y = 0; y < shape.samples_y; ++y)
    for (uint32_t x = 0; x < shape.samples_x; ++x)
      w.put(scene.frame().height_quantum_m * scene.height(proto::NodeId::at(x, y)));
  return writeFile(bytes, file);
}

nlohmann::ordered_json groundOf(const terrain::Scene& scene, const std::filesystem::path& heights) {
  const proto::Frame& frame = scene.frame();
  const proto::GridShape& shape = scene.grid().shape();
  return {{"heights", heights.string()},
          {"width", shape.samples_x},
          {"height", shape.samples_y},
          {"west_deg", kDegrees * frame.longitude0_rad},
          {"south_deg", kDegrees * frame.latitude0_rad},
          {"step_deg", {kDegrees * frame.longitude_step_rad, kDegrees * frame.latitude_step_rad}},
          {"semi_major_m", frame.semi_major_m},
          {"flattening", frame.flattening},
          {"origin_deg", {kDegrees * frame.origin.longitude_rad, kDegrees * frame.origin.latitude_rad}},
          {"origin_height_m", frame.origin.height_m}};
}

nlohmann::ordered_json posesOf(const RivalsFlight& flight) {
  nlohmann::ordered_json poses = nlohmann::ordered_json::array();
  const Duration step = Duration::seconds(1 / flight.poses_per_s);
  for (Time t = flight.path.start; (t - flight.path.start).toSeconds() <= flight.seconds; t = t + step) {
    const proto::Pose pose = flight.path.at(t);
    const glm::dquat& q = pose.orientation;
    poses.push_back({{"eye", {pose.eye.x, pose.eye.y, pose.eye.z}}, {"orientation", {q.x, q.y, q.z, q.w}}});
  }
  return poses;
}

}  // namespace

std::filesystem::path rivalsSources() { return labFolder() / "rivals"; }

Result<nlohmann::ordered_json> writeFlightPlan(const RivalsFlight& flight, const std::filesystem::path& folder) {
  if (Status s = checkScene(*flight.scene); !s.ok()) return s.error();
  const std::filesystem::path heights = folder / "heights.f64";
  if (Status s = writeHeights(*flight.scene, heights); !s.ok()) return s.error();
  return nlohmann::ordered_json{{"scene", std::filesystem::absolute(flight.scene_path).string()},
                                {"ground", groundOf(*flight.scene, heights)},
                                {"poses_per_s", flight.poses_per_s},
                                {"poses", posesOf(flight)},
                                {"lens",
                                 {{"fov_rad", flight.lens.vertical_fov_rad},
                                  {"width_px", flight.lens.width_px},
                                  {"height_px", flight.lens.height_px}}},
                                {"tau_px", flight.tau_px}};
}

}  // namespace foreland::lab
