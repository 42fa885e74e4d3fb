#include "oracle/surface/objects_oracle.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>

#include "oracle/surface/object_cracks.h"
#include "oracle/surface/oracle_eye.h"
#include "oracle/surface/surface_truth.h"

namespace foreland::oracle {

namespace {

ModelTruth modelTruth(const proto::ObjectModel& model, const proto::ModelNodes& nodes) {
  terrain::TrueSurface surface{proto::MeshTopology::create(model.shape).value(), model.quantum_m, model.base, {}};
  surface.nodes.reserve(nodes.records.size());
  for (const proto::SurfaceRecord& record : nodes.records) surface.nodes.push_back(record.position);
  const auto faces = static_cast<uint32_t>(model.shape.faces.size());
  std::vector<std::vector<glm::dvec3>> poses;
  for (size_t k = 0; k < nodes.moves_each; ++k) {
    terrain::TrueSurface moved = surface;
    for (size_t v = 0; v < moved.base.size(); ++v) moved.base[v] += model.base_moves[v * nodes.moves_each + k];
    for (size_t n = 0; n < moved.nodes.size(); ++n) moved.nodes[n] += nodes.moves[n * nodes.moves_each + k];
    poses.push_back(truthOf(moved).positions);
  }
  return {.surface = truthOf(surface),
          .faces = model.shape.faces,
          .weight_sum = static_cast<int32_t>(surface.topology.weightScale()),
          .layout = client::parameterLayout(faces, model.atlas_side),
          .pose_epochs = model.pose_epochs,
          .poses = std::move(poses)};
}

glm::dvec3 toModel(const proto::ObjectPlacement& placement, const glm::dvec3& p) {
  return glm::conjugate(placement.orientation) * (p - placement.position) / placement.scale;
}

proto::Pose toModel(const proto::ObjectPlacement& placement, const proto::Pose& pose) {
  return {toModel(placement, pose.eye), glm::conjugate(placement.orientation) * pose.orientation};
}

}  // namespace

ObjectsTruth objectsTruth(const proto::ObjectSet& objects, std::span<const proto::ModelNodes> nodes) {
  ObjectsTruth truth;
  for (size_t i = 0; i < objects.models().size(); ++i)
    truth.models.push_back(modelTruth(objects.models()[i], nodes[i]));
  for (size_t i = 0; i < objects.size(); ++i) {
    truth.objects.push_back({objects.placement(i).model, objects.placement(i), objects.domain(i).nearest_m});
    truth.interior_per_tau = objects.domain(i).interior_per_tau;
  }
  return truth;
}

std::optional<SurfacePoint> pointAt(const ModelTruth& model, const glm::vec2& coordinates) {
  constexpr double kRounding = 0.02;  // of floats, in lattice intervals; a tenth of it for the largest models
  const proto::AtlasLayout& layout = model.layout;
  const glm::dvec2 pixel = glm::dvec2(coordinates) * glm::dvec2(layout.width(), layout.height());
  if (!(pixel.x >= 0 && pixel.y >= 0 && pixel.x < layout.width() && pixel.y < layout.height())) return std::nullopt;
  const auto face = layout.faceAt(glm::uvec2(pixel));
  if (!face) return std::nullopt;
  const glm::dvec2 from_corner = pixel - 0.5 - glm::dvec2(layout.pixel(*face, 0, 0));
  const glm::dvec2 weights =
      (*face % 2 == 0 ? from_corner : -from_corner) * (static_cast<double>(model.weight_sum) / layout.side);
  const glm::dvec2 whole = glm::round(weights);
  if (glm::length(weights - whole) > kRounding || whole.x < 0 || whole.y < 0 || whole.x + whole.y > model.weight_sum)
    return std::nullopt;
  return SurfacePoint{*face, {static_cast<int32_t>(whole.x), static_cast<int32_t>(whole.y)}};
}

ObjectsOracle::ObjectsOracle(ObjectsTruth truth) : truth_(std::move(truth)) {
  for (const ModelTruth& model : truth_.models) models_.push_back(posedModel(model, {}));
}

// `shares` of all poses; none: the first one.
ObjectsOracle::Model ObjectsOracle::posedModel(const ModelTruth& truth, std::span<const double> shares) {
  SurfaceTruth surface = truth.surface;
  for (size_t v = 0; v < surface.positions.size() && !shares.empty(); ++v) {
    surface.positions[v] *= shares[0];
    for (size_t pose = 1; pose < shares.size(); ++pose) surface.positions[v] += shares[pose] * truth.poses[pose - 1][v];
  }
  glm::dvec3 low(1e300), high(-1e300);
  for (const glm::dvec3& p : surface.positions) low = glm::min(low, p), high = glm::max(high, p);
  const glm::dvec3 centre = 0.5 * (low + high);
  double radius = 0;
  for (const glm::dvec3& p : surface.positions) radius = std::max(radius, glm::distance(p, centre));
  return {SurfaceOracle(std::move(surface)), centre, radius};
}

std::vector<DrawnTriangle> ObjectsOracle::drawnTriangles(const client::KeyframeMesh& mesh, size_t object,
                                                         const proto::ObjectPlacement& placement, double weight) const {
  const ObjectTruth& truth = truth_.objects[object];
  const client::ObjectPart& part = mesh.object_parts[object];
  const client::BlendMesh& drawn = mesh.objects;
  std::vector<DrawnTriangle> triangles;
  triangles.reserve(part.index_count / 3);
  for (uint32_t i = part.first_index; i + 2 < part.first_index + part.index_count; i += 3) {
    DrawnTriangle t;
    bool is_sound = true;
    for (uint32_t k = 0; k < 3; ++k) {
      const uint32_t v = drawn.indices[i + k];
      const auto point = pointAt(truth_.models[truth.model], drawn.parameters[v]);
      is_sound = is_sound && point && (k == 0 || point->face == t.face);
      if (!is_sound) break;
      t.face = point->face;
      t.weights[k] = point->weights;
      t.positions[k] = toModel(placement, mesh.origin + glm::dvec3(drawn.at(v, weight)));
    }
    if (is_sound) triangles.push_back(t);  // where it is not, nothing is drawn: a hole, and findCracks names it
  }
  return triangles;
}

SurfaceJudgement ObjectsOracle::judge(const client::KeyframeMesh& mesh, double weight, const proto::Pose& pose,
                                      const proto::Lens& lens, std::span<const glm::dvec3> carried,
                                      std::span<const std::vector<double>> pose_shares, const Sight& sight,
                                      const Stretch& stretch) const {
  SurfaceJudgement all;
  std::vector<std::optional<Model>> posed(models_.size());
  for (size_t i = 0; i < pose_shares.size(); ++i)
    if (!pose_shares[i].empty()) posed[i] = posedModel(truth_.models[i], pose_shares[i]);
  for (size_t i = 0; i < truth_.objects.size(); ++i) {
    const ObjectTruth& object = truth_.objects[i];
    proto::ObjectPlacement placement = object.placement;
    if (!carried.empty()) placement.position += carried[i];
    const Model& model = posed[object.model] ? *posed[object.model] : models_[object.model];
    const proto::Pose seen_from = toModel(placement, pose);
    const Stretch stretched{stretch.factor, glm::conjugate(placement.orientation) * stretch.along};
    if (!OracleEye(seen_from, lens, stretched).maySee(model.centre, model.radius)) continue;
    const bool is_drawn = i < mesh.object_parts.size();
    const SurfaceJudgement one = model.oracle.judge(
        is_drawn ? drawnTriangles(mesh, i, placement, weight) : std::vector<DrawnTriangle>(), seen_from, lens,
        object.nearest_m,
        [&](const glm::dvec3& p, double px, bool is_silhouette) {
          const double per_tau = is_silhouette ? 1 : truth_.interior_per_tau;
          return sight.counts(px / per_tau, placement.toScene(p), pose.eye);
        },
        stretched);
    all.silhouette.merge(one.silhouette);
    all.interior.merge(one.interior);
    all.max_m = std::max(all.max_m, one.max_m * object.placement.scale);
    all.uncovered += one.uncovered;
  }
  return all;
}

CrackReport ObjectsOracle::findCracks(const client::KeyframeMesh& mesh) const {
  CrackReport all;
  if (mesh.object_parts.size() != truth_.objects.size())
    all = {1,
           std::to_string(mesh.object_parts.size()) + " objects are drawn of " + std::to_string(truth_.objects.size())};
  for (size_t i = 0; i < std::min(mesh.object_parts.size(), truth_.objects.size()); ++i) {
    const CrackReport one =
        findObjectCracks(mesh.objects, mesh.object_parts[i], truth_.models[truth_.objects[i].model]);
    if (all.cracks == 0 && one.cracks > 0) all.first = "object " + std::to_string(i) + ": " + one.first;
    all.cracks += one.cracks;
  }
  return all;
}

}  // namespace foreland::oracle
