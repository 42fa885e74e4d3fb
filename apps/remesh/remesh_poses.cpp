#include "apps/remesh/remesh_poses.h"

#include <utility>

#include "apps/options/date.h"
#include "proto/section/poses.h"
#include "terrain/model/origin.h"
#include "terrain/model/read_model.h"
#include "terrain/remesh/remeshed_surface.h"

namespace foreland::apps {

Result<terrain::Model> readUpright(const std::filesystem::path& file, const ModelReading& reading) {
  auto model = terrain::readModel(file, reading.allowed);
  if (model.ok() && reading.up.value_or(model->up) == terrain::UpAxis::kY) terrain::standUp(*model);
  return model;
}

Result<std::vector<Pose>> readPoses(const std::vector<std::string>& texts, const ModelReading& reading,
                                    const glm::dvec3& origin, const terrain::Model& model,
                                    const terrain::Original& original) {
  const auto refuse = [](const std::string& what) { return Error{ErrorCode::kInvalidArgument, what}; };
  if (texts.size() == 1 || texts.size() > proto::kMaxPoses)
    return refuse("--pose is given " + std::to_string(texts.size()) + " times; a surface has 2 to " +
                  std::to_string(proto::kMaxPoses) + " poses, or none");
  std::vector<Pose> poses;
  for (const std::string& text : texts) {
    const size_t split = text.find('=');
    const auto time = split == std::string::npos ? std::nullopt : parseDate(text.substr(0, split));
    if (!time || split + 1 == text.size())
      return refuse("--pose " + text + ": write YYYY-MM-DD=FILE, for example 2004-10-04=crane-2.obj");
    if (!poses.empty() && *time <= poses.back().time)
      return refuse("--pose " + text + ": the dates of poses must ascend, but " + poses.back().date + " is before it");
    auto posed = readUpright(text.substr(split + 1), reading);
    if (!posed.ok()) return posed.error();
    terrain::moveTo(origin, *posed);
    auto positions = terrain::positionsInPose(original, model, *posed);
    if (!positions.ok()) return positions.error();
    poses.push_back({*time, text.substr(0, split), std::move(*posed), std::move(*positions)});
  }
  return poses;
}

Result<PosedSurface> makePosed(const std::vector<Pose>& poses, const terrain::Original& original,
                               const terrain::Remeshed& remeshed, proto::MeshRule rule, double step, unsigned threads) {
  std::optional<terrain::TrueSurface> first;
  std::vector<PoseReport> reports;
  for (const Pose& pose : poses) {
    if (Status s = terrain::checkQuantum(pose.positions, step); !s.ok())
      return Error{s.error().code, pose.model.name + ": " + s.error().message};
    auto surface = terrain::toSurface(terrain::posedAs(remeshed, original, pose.positions), rule, step);
    if (!surface.ok()) return surface.error();
    terrain::Original moved = original;
    moved.positions = pose.positions;
    reports.push_back({pose.date, judgeRemesh(pose.model, moved, *surface, threads).hausdorff()});
    if (first)
      first->poses.push_back({std::move(surface->base), std::move(surface->nodes)});
    else
      first = std::move(*surface);
  }
  return PosedSurface{std::move(*first), std::move(reports)};
}

}  // namespace foreland::apps
