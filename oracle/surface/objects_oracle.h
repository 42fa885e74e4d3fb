// Judges the objects of a drawn mesh, as SurfaceOracle judges one surface: every vertex of every object's full
// resolution that the camera sees, on its silhouette or inside, against the point drawn at the same parameter. Which
// parameter a drawn vertex has follows from its texture coordinates (proto/topology/atlas_layout.h), so a vertex that
// is drawn at the wrong texture coordinates is found as well. It shares no code with the refiner.
//
// Immutable; any thread. Cost: SurfaceOracle's, for the objects that may be in view.
#pragma once

#include <glm/gtc/quaternion.hpp>
#include <optional>
#include <span>
#include <vector>

#include "client/mesh/patch/keyframe_mesh.h"
#include "oracle/crack_checker.h"
#include "oracle/oracle.h"
#include "oracle/surface/surface_oracle.h"
#include "proto/refine/surface/objects.h"
#include "proto/section/poses.h"

namespace foreland::oracle {

// A surface of which objects are copies, in its own frame.
struct ModelTruth {
  SurfaceTruth surface;
  std::vector<std::array<uint32_t, 3>> faces;  // of the base: vertices that faces share have one number
  int32_t weight_sum = 1;                      // of SurfacePoint's three weights
  proto::AtlasLayout layout;                   // by which texture coordinates follow from face and weights
  // Its poses but the first: the epochs of all, and positions as in `surface`.
  std::vector<uint32_t> pose_epochs;
  std::vector<std::vector<glm::dvec3>> poses;
};

struct ObjectTruth {
  uint32_t model = 0;
  proto::ObjectPlacement placement;
  double nearest_m = 0;  // in the model's frame: points at less depth are not judged
};

struct ObjectsTruth {
  std::vector<ModelTruth> models;
  std::vector<ObjectTruth> objects;
  double interior_per_tau = 1;  // tolerance where there is no silhouette, as a multiple of tau
};

// `nodes` of each model; they are not needed afterwards.
ObjectsTruth objectsTruth(const proto::ObjectSet& objects, std::span<const proto::ModelNodes> nodes);

// Which point of the surface a vertex with these texture coordinates is; nothing if it is no vertex of a refinement.
std::optional<SurfacePoint> pointAt(const ModelTruth& model, const glm::vec2& coordinates);

class ObjectsOracle {
 public:
  explicit ObjectsOracle(ObjectsTruth truth);

  // Over all objects. `max_m` is in the scene's metres, over the objects that may be in view. The camera is in the
  // scene's frame; what is drawn is mix(from, to, weight). `carried`: where each object ought to be by then, from where
  // it was placed; none: there. `pose_shares`: by model with poses, how much each contributes; none: the first alone.
  // Errors above `sight`'s limit, inside times interiorPerTau(), count only where the true vertex is seen. `stretch` is
  // in the scene's frame.
  SurfaceJudgement judge(const client::KeyframeMesh& mesh, double weight, const proto::Pose& pose,
                         const proto::Lens& lens, std::span<const glm::dvec3> carried = {},
                         std::span<const std::vector<double>> pose_shares = {}, const Sight& sight = {},
                         const Stretch& stretch = {}) const;
  // Of all objects; object_cracks.h says what is found.
  CrackReport findCracks(const client::KeyframeMesh& mesh) const;

  double interiorPerTau() const { return truth_.interior_per_tau; }
  size_t size() const { return truth_.objects.size(); }
  const ObjectsTruth& truth() const { return truth_; }

 private:
  struct Model {
    SurfaceOracle oracle;
    glm::dvec3 centre;
    double radius;  // of a sphere around all vertices
  };
  static Model posedModel(const ModelTruth& truth, std::span<const double> shares);
  std::vector<DrawnTriangle> drawnTriangles(const client::KeyframeMesh& mesh, size_t object,
                                            const proto::ObjectPlacement& placement, double weight) const;

  ObjectsTruth truth_;
  std::vector<Model> models_;
};

}  // namespace foreland::oracle
