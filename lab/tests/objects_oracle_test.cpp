// The oracle of objects on what a client draws of a scene with objects of either rule.
#include "oracle/surface/objects_oracle.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "client/replica.h"
#include "lab/sections/errors.h"
#include "oracle/reference/whole_mesh.h"
#include "oracle/scene_truth.h"
#include "server/section/sender.h"
#include "server/session/world.h"
#include "server/view/tour.h"
#include "tests/support/scene.h"
#include "tests/world/ring_of_objects.h"

namespace foreland::lab {
namespace {

constexpr proto::Lens kLens{.vertical_fov_rad = 1.0, .width_px = 1280, .height_px = 720};

class ObjectsOracleTest : public testing::Test {
 protected:
  static const std::shared_ptr<const terrain::Scene>& scene() {
    static const auto made = test::makeScene(301, 217, 31);
    return made;
  }
  ObjectsOracleTest()
      : hierarchy_(scene(), proto::ErrorBound::kSpheroid, test::objectsIn(*scene(), 8)),
        path_(*server::planTour(*scene(), "orbit", 10)),
        oracle_(oracle::objectsTruth(hierarchy_.objects().set, hierarchy_.objects().nodes)) {}

  // The mesh between the keyframes at two seconds and a little later.
  client::KeyframeMesh drawnMesh() {
    server::SectionSender sender(hierarchy_);
    server::SendScratch scratch;
    client::Replica replica(server::welcomeTo(hierarchy_));
    client::KeyframeMesh mesh;
    for (double t : {2.0, 2.2}) {
      Bytes message;
      sender.send({path_.at(Time::seconds(t)), kLens, 1}, Time::seconds(t), scratch, message);
      CHECK_TRUE(replica.apply(sender.keyframe(), ByteSpan(message).subspan(sender.headerBytes())).ok());
      mesh = oracle::wholeMesh(replica);
    }
    return mesh;
  }
  oracle::SurfaceJudgement judged(const client::KeyframeMesh& mesh, double weight) const {
    return oracle_.judge(mesh, weight, path_.at(Time::seconds(2.2)), kLens);
  }
  // A vertex that is drawn and seen at weight 1, in front of its object's middle.
  uint32_t seenVertex(const client::KeyframeMesh& mesh) const {
    const proto::Pose pose = path_.at(Time::seconds(2.2));
    for (size_t i = 0; i < mesh.object_parts.size(); ++i) {
      const client::ObjectPart& part = mesh.object_parts[i];
      const glm::dvec3 middle = hierarchy_.objects().set.placement(i).position;
      for (uint32_t k = part.first_index; k < part.first_index + part.index_count; ++k) {
        const glm::dvec3 p = mesh.origin + glm::dvec3(mesh.objects.to_positions[mesh.objects.indices[k]]);
        const glm::dvec3 d = p - pose.eye;
        const double depth = glm::dot(d, pose.forward()), limit = 0.3 * depth;
        const bool is_central =
            std::fabs(glm::dot(d, pose.right())) < limit && std::fabs(glm::dot(d, pose.up())) < limit;
        if (depth > 0 && is_central && glm::distance(p, pose.eye) < glm::distance(middle, pose.eye))
          return mesh.objects.indices[k];
      }
    }
    ADD_FAILURE() << "no object is in view";
    return 0;
  }

  server::Hierarchy hierarchy_;
  proto::Path path_;
  oracle::ObjectsOracle oracle_;
};

TEST_F(ObjectsOracleTest, FindsNoCrackAndNoHoleInWhatAClientDraws) {
  const client::KeyframeMesh mesh = drawnMesh();
  const oracle::CrackReport cracks = oracle_.findCracks(mesh);
  EXPECT_EQ(cracks.cracks, 0u) << cracks.first;
  for (double weight : {0.0, 0.4, 1.0}) {
    const oracle::SurfaceJudgement all = judged(mesh, weight);
    EXPECT_EQ(all.uncovered, 0u);
    EXPECT_GT(all.silhouette.vertices, 20u);
    EXPECT_GT(all.interior.vertices, 200u);
  }
}

TEST_F(ObjectsOracleTest, KnowsEveryVertexByItsTextureCoordinates) {
  const oracle::ObjectsTruth truth = oracle::objectsTruth(hierarchy_.objects().set, hierarchy_.objects().nodes);
  for (const oracle::ModelTruth& model : truth.models)
    for (const oracle::SurfacePoint& p : model.surface.points) {
      const double v = p.weights[0], w = p.weights[1], sum = model.weight_sum;
      const auto found =
          oracle::pointAt(model, glm::vec2(model.layout.coordinates(p.face, glm::dvec3(sum - v - w, v, w) / sum)));
      ASSERT_TRUE(found);
      EXPECT_EQ(found->face, p.face);
      EXPECT_EQ(found->weights, p.weights);
    }
}

TEST_F(ObjectsOracleTest, KeepsTheTolerancesAtEveryWeightOfAFlight) {
  const FlightOptions options{.lens = kLens, .seconds = 4};
  const auto views = keyframeViews(path_, options, Guarantee::kEveryFrame);
  const SectionErrors errors = measureErrors(hierarchy_, views, path_, options, {.measure_every = 6});
  EXPECT_EQ(errors.measure_every, 7u);
  EXPECT_EQ(errors.weights_judged.distinct(), 12u);
  EXPECT_EQ(errors.frames_over_tau, 0u);
  EXPECT_EQ(errors.cracks, 0u);
  EXPECT_EQ(errors.uncovered_samples, 0u);
  EXPECT_GT(errors.object_vertices_judged, 10'000u);
  EXPECT_LE(errors.object_silhouette_error_px, 1.0);
  EXPECT_GT(errors.object_silhouette_error_px, 0.2);
  EXPECT_LE(errors.object_interior_error_px, errors.object_interior_per_tau);
  EXPECT_GT(errors.object_interior_error_px, 1.0);
}

TEST_F(ObjectsOracleTest, AMovedVertexRaisesTheErrorOfTheWholeScene) {
  client::KeyframeMesh mesh = drawnMesh();
  const proto::Pose pose = path_.at(Time::seconds(2.2));
  oracle::SceneOracle whole(oracle::truthOf(scene()),
                            oracle::objectsTruth(hierarchy_.objects().set, hierarchy_.objects().nodes));
  const oracle::SceneDeviation before = whole.error(mesh, 1, pose, kLens, 1);
  EXPECT_LE(before.max_px, 1.0);
  const glm::dvec3 aside = 20.0 * pose.right();
  mesh.objects.to_positions[seenVertex(mesh)] += glm::vec4(glm::vec3(aside), 0);
  const oracle::SceneDeviation after = whole.error(mesh, 1, pose, kLens, 1);
  EXPECT_GT(after.max_px, before.max_px + 1);
  EXPECT_GT(std::max(after.silhouette_px, after.interior_px), 7.0);
  EXPECT_LE(whole.error(mesh, 0, pose, kLens, 1).max_px, before.max_px + 1);  // it is moved at the other end only
}

TEST_F(ObjectsOracleTest, AMissingTriangleIsACrackAndAHole) {
  client::KeyframeMesh mesh = drawnMesh();
  const uint32_t vertex = seenVertex(mesh);
  const auto at = std::ranges::find(mesh.objects.indices, vertex) - mesh.objects.indices.begin();
  const size_t first = static_cast<size_t>(at) / 3 * 3;
  for (size_t k = 1; k < 3; ++k) mesh.objects.indices[first + k] = mesh.objects.indices[first];
  EXPECT_GT(oracle_.findCracks(mesh).cracks, 3u);  // no area, a face that is not covered, three open edges
}

TEST_F(ObjectsOracleTest, AGapBetweenBaseFacesIsACrack) {
  client::KeyframeMesh mesh = drawnMesh();
  // A vertex on a base edge is stored once for each of its faces.
  const auto& positions = mesh.objects.to_positions;
  size_t gaps = 0;
  for (size_t v = 0; v + 1 < positions.size() && gaps == 0; ++v)
    if (std::ranges::find(positions.begin() + static_cast<ptrdiff_t>(v) + 1, positions.end(), positions[v]) !=
        positions.end()) {
      mesh.objects.to_positions[v].z += 0.01f;
      ++gaps;
    }
  ASSERT_EQ(gaps, 1u);
  EXPECT_GE(oracle_.findCracks(mesh).cracks, 1u);
}

TEST_F(ObjectsOracleTest, AFlippedTriangleIsACrack) {
  client::KeyframeMesh mesh = drawnMesh();
  std::swap(mesh.objects.indices[0], mesh.objects.indices[1]);
  EXPECT_GT(oracle_.findCracks(mesh).cracks, 0u);
}

TEST_F(ObjectsOracleTest, AVertexAtTextureCoordinatesOfNoneIsACrack) {
  client::KeyframeMesh mesh = drawnMesh();
  mesh.objects.parameters[mesh.objects.indices[0]] += 0.001f;
  EXPECT_GT(oracle_.findCracks(mesh).cracks, 0u);
}

TEST_F(ObjectsOracleTest, AnObjectThatIsNotDrawnIsACrack) {
  client::KeyframeMesh mesh = drawnMesh();
  mesh.object_parts.pop_back();
  EXPECT_GT(oracle_.findCracks(mesh).cracks, 0u);
}

}  // namespace
}  // namespace foreland::lab
