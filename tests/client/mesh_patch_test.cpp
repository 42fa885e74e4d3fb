// The mesh by change is the mesh made anew, bit for bit, through any sequence of keyframes, extended transitions,
// restarts and meshes that nobody took; its ranges of changes hold all that changed.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <set>
#include <utility>

#include "client/mesh/patch/blend_patch.h"
#include "client/replica.h"
#include "oracle/reference/whole_mesh.h"
#include "server/section/sender.h"
#include "server/session/world.h"
#include "tests/support/globe_scene.h"
#include "tests/support/same_mesh.h"
#include "tests/support/scene.h"
#include "tests/support/seed.h"
#include "tests/support/wanderer.h"
#include "tests/world/ring_of_objects.h"

namespace foreland::test {
namespace {

using client::Blend;
using client::KeyframeMesh;

// Whether ranges, of elements of so many bytes, lie so far apart that none ought to be one with the next.
bool areApart(const std::vector<client::Range>& ranges, size_t bytes, size_t gap) {
  for (size_t i = 1; i < ranges.size(); ++i)
    if ((ranges[i].begin - ranges[i - 1].end) * bytes <= gap) return false;
  return true;
}

// What a graphics card holds that is sent the ranges of changes alone.
struct Uploaded {
  client::BlendMesh mesh;

  void take(client::PatchedMesh& patched, const client::BlendMesh& from, size_t gap) {
    const bool is_all = patched.isAllChanged();
    client::ChangedRanges changes;
    if (!is_all) patched.collectChanges(gap, changes);
    for (const auto* positions : {&changes.from_positions, &changes.to_positions})
      ASSERT_TRUE(areApart(*positions, sizeof(glm::vec4), gap));
    for (const auto* normals : {&changes.from_normals, &changes.to_normals})
      ASSERT_TRUE(areApart(*normals, sizeof(uint32_t), gap));
    ASSERT_TRUE(areApart(changes.parameters, sizeof(glm::vec2), gap));
    ASSERT_TRUE(areApart(changes.bends, sizeof(glm::vec3), gap));
    ASSERT_TRUE(areApart(changes.triangles, 3 * sizeof(uint32_t), gap));
    const auto upload = [&](const std::vector<client::Range>& ranges, size_t each, const auto& source, auto& held) {
      held.resize(source.size());
      if (is_all) held = source;
      if (source.empty()) return;  // what the ground has moved, if it does not
      for (const client::Range& r : ranges)
        std::copy(source.begin() + static_cast<ptrdiff_t>(each * r.begin),
                  source.begin() + static_cast<ptrdiff_t>(each * r.end),
                  held.begin() + static_cast<ptrdiff_t>(each * r.begin));
    };
    upload(changes.from_positions, 1, from.from_positions, mesh.from_positions);
    upload(changes.to_positions, 1, from.to_positions, mesh.to_positions);
    upload(changes.from_positions, 1, from.from_moved, mesh.from_moved);
    upload(changes.to_positions, 1, from.to_moved, mesh.to_moved);
    upload(changes.bends, 1, from.from_bends, mesh.from_bends);
    upload(changes.bends, 1, from.to_bends, mesh.to_bends);
    upload(changes.from_normals, 1, from.from_normals, mesh.from_normals);
    upload(changes.to_normals, 1, from.to_normals, mesh.to_normals);
    upload(changes.parameters, 1, from.parameters, mesh.parameters);
    upload(changes.triangles, 3, from.indices, mesh.indices);
    patched.clearChanges();
  }
  bool holds(const client::BlendMesh& other) const {
    return mesh.from_positions == other.from_positions && mesh.to_positions == other.to_positions &&
           mesh.from_moved == other.from_moved && mesh.to_moved == other.to_moved &&
           mesh.from_bends == other.from_bends && mesh.to_bends == other.to_bends &&
           mesh.from_normals == other.from_normals && mesh.to_normals == other.to_normals &&
           mesh.parameters == other.parameters && mesh.indices == other.indices;
  }
};

class MeshPatches : public testing::Test {
 protected:
  // With another size each time; `epochs` 0: the ground does not move.
  void begin(proto::FrameKind kind, size_t epochs) {
    const auto samples_x = static_cast<uint32_t>(100 + rng_.below(80)),
               samples_y = static_cast<uint32_t>(90 + rng_.below(80));
    if (kind == proto::FrameKind::kGlobe)
      return begin(makeGlobeScene(7, seed_, static_cast<uint32_t>(rng_.below(2)) * 5), 0);
    scene_ = epochs > 0 ? makeMovingScene(samples_x, samples_y, seed_, epochs, kind)
                        : makeScene(samples_x, samples_y, seed_, kind);
    begin(scene_, 6);
  }
  void begin(std::shared_ptr<const terrain::Scene> scene, size_t objects) {
    scene_ = std::move(scene);
    hierarchy_.emplace(scene_, proto::ErrorBound::kSpheroid,
                       objects > 0 ? objectsIn(*scene_, objects) : decltype(objectsIn(*scene_, objects)){});
    sender_.emplace(*hierarchy_);
    replica_.emplace(server::welcomeTo(*hierarchy_));
    shown_ = {};
    terrain_.emplace(shown_);
    objects_.emplace(shown_.objects);
  }

  void keyframe(const proto::View& view, Blend blend) {
    if (rng_.below(12) == 0) sender_.emplace(*hierarchy_);  // the next keyframe starts from nothing
    now_ = now_ + Duration::milliseconds(20 + static_cast<int64_t>(rng_.below(400)));
    if (!scene_->epochs().epochs().empty()) moveSceneTime();
    Bytes message;
    sender_->send(view, now_, scratch_, message);
    const auto status = replica_->apply(sender_->keyframe(), ByteSpan(message).subspan(sender_->headerBytes()), blend);
    CHECK_TRUE(status.ok());
  }

  // It stands, goes on or back, or is somewhere else.
  void moveSceneTime() {
    const proto::Epochs& epochs = scene_->epochs().epochs();
    const auto span = static_cast<double>((epochs.last() - epochs.first()).us);
    if (rng_.below(4) == 0) return sender_->showAt(scene_time_);
    const double wanted = rng_.below(8) == 0 ? static_cast<double>(epochs.first().us) + rng_.uniform(0, span)
                                             : static_cast<double>(scene_time_.us) + rng_.uniform(-0.05, 0.1) * span;
    scene_time_ = epochs.towards(scene_time_, epochs.clamp(wanted));
    sender_->showAt(scene_time_);
  }

  void expectSame() {
    client::MeshPatch patch;
    replica_->makePatch(patch);
    terrain_->apply(patch.terrain);
    objects_->apply(patch.objects);
    const KeyframeMesh anew = oracle::wholeMesh(*replica_);
    ASSERT_EQ(patch.origin, anew.origin);
    ASSERT_TRUE(isSameMesh(shown_, anew));
    shown_.object_parts = patch.object_parts;
    ASSERT_TRUE(areSameObjects(shown_, anew));
    ASSERT_EQ(patch.from_nodes, anew.from_nodes);
    ASSERT_EQ(patch.to_nodes, anew.to_nodes);
    if (rng_.below(3) > 0) {  // otherwise the next upload is of the changes of several meshes
      const size_t gap = rng_.below(2) * client::kUploadGap;
      uploaded_[0].take(*terrain_, shown_, gap);
      uploaded_[1].take(*objects_, shown_.objects, gap);
      ASSERT_TRUE(uploaded_[0].holds(shown_));
      ASSERT_TRUE(uploaded_[1].holds(shown_.objects));
    }
    ASSERT_LE(shown_.parameters.size(), 2 * anew.parameters.size() + client::kFewPlaces);
    const auto expectFew = [&](size_t places,
                               size_t drawn) {  // a range has at least 32, and at most four times, what it needs
      ASSERT_LE(places, 2 * (4 * drawn + 4 * 32 * anew.object_parts.size()) + client::kFewPlaces);
    };
    ASSERT_NO_FATAL_FAILURE(expectFew(shown_.objects.triangleCount(), anew.objects.triangleCount()));
    ASSERT_NO_FATAL_FAILURE(expectFew(shown_.objects.parameters.size(),
                                      2 * anew.objects.parameters.size() + 256 * anew.object_parts.size()));
    whole_ += patch.terrain.is_whole;
    ++all_;
  }

  const uint64_t seed_ = randomSeed();
  Rng rng_{seed_};
  std::shared_ptr<const terrain::Scene> scene_;
  std::optional<server::Hierarchy> hierarchy_;
  std::optional<server::SectionSender> sender_;
  std::optional<client::Replica> replica_;
  server::SendScratch scratch_;
  Time now_ = Time::seconds(1), scene_time_;
  KeyframeMesh shown_;
  std::optional<client::PatchedMesh> terrain_, objects_;
  std::array<Uploaded, 2> uploaded_;  // of the terrain, and of objects
  size_t whole_ = 0, all_ = 0;
};

TEST_F(MeshPatches, MakeTheMeshThatIsMadeAnew) {
  for (proto::FrameKind kind : {proto::FrameKind::kPlanar, proto::FrameKind::kGeographic})
    for (Blend blend : client::kBlends) {
      begin(kind, rng_.below(2) * 5);
      Wanderer wanderer(*hierarchy_, rng_.below(1u << 30));
      const auto next_blend = [&] { return rng_.below(8) > 0 ? blend : client::kBlends[rng_.below(4)]; };
      for (int i = 0; i < 60; ++i) {
        keyframe(wanderer.next(), next_blend());
        if (rng_.below(10) == 0) continue;  // nobody takes this mesh
        ASSERT_NO_FATAL_FAILURE(expectSame()) << "mesh " << i << ", " << client::name(blend);
        if (rng_.below(3) > 0) continue;
        replica_->extend(Duration::milliseconds(250), blend);
        ASSERT_NO_FATAL_FAILURE(expectSame()) << "after mesh " << i << ", " << client::name(blend);
      }
    }
  EXPECT_LT(3 * whole_, all_) << "most meshes should follow from the last one";
}

// Each edge has a triangle on either side, once each way round.
::testing::AssertionResult isClosed(const client::BlendMesh& mesh) {
  std::set<std::pair<uint32_t, uint32_t>> edges;
  for (size_t i = 0; i + 2 < mesh.indices.size(); i += 3) {
    const std::array corners{mesh.indices[i], mesh.indices[i + 1], mesh.indices[i + 2]};
    if (corners[0] == corners[1] && corners[0] == corners[2]) continue;
    for (size_t k = 0; k < 3; ++k)
      if (!edges.emplace(corners[k], corners[(k + 1) % 3]).second)
        return ::testing::AssertionFailure() << "an edge has two triangles on one side";
  }
  for (const auto& [a, b] : edges)
    if (!edges.contains({b, a})) return ::testing::AssertionFailure() << "an edge has a triangle on one side only";
  return ::testing::AssertionSuccess();
}

TEST_F(MeshPatches, OfAGlobeAreClosedWhereverTheyChange) {
  for (Blend blend : client::kBlends) {
    begin(proto::FrameKind::kGlobe, 0);
    Wanderer wanderer(*hierarchy_, rng_.below(1u << 30));
    for (int i = 0; i < 60; ++i) {
      keyframe(wanderer.next(), blend);
      ASSERT_NO_FATAL_FAILURE(expectSame()) << "mesh " << i << ", " << client::name(blend);
      ASSERT_TRUE(isClosed(shown_)) << "mesh " << i << ", " << client::name(blend);
    }
  }
}

// Without what it has moved, the ground is drawn as the first epoch's is at the same views: sections do not depend on
// the scene time, and what a vertex has moved is blended as its height is.
TEST(MovedGround, IsTheGroundOfTheFirstEpochAndWhatItHasMoved) {
  const uint64_t seed = randomSeed();
  SCOPED_TRACE(seed);
  Rng rng(seed);
  double max_m = 0;  // of some of the scenes next to nothing moves in view
  for (uint64_t k = 0; k < 6; ++k) {
    const auto scene = makeMovingScene(130, 110, seed + k / 2, 5,
                                       k % 2 == 0 ? proto::FrameKind::kPlanar : proto::FrameKind::kGeographic);
    const server::Hierarchy hierarchy(scene);
    const proto::Epochs& epochs = scene->epochs().epochs();
    std::array<server::SectionSender, 2> senders{server::SectionSender(hierarchy), server::SectionSender(hierarchy)};
    std::array<client::Replica, 2> replicas{client::Replica(server::welcomeTo(hierarchy)),
                                            client::Replica(server::welcomeTo(hierarchy))};
    server::SendScratch scratch;
    Wanderer wanderer(hierarchy, seed + k);
    for (int i = 0; i < 20; ++i) {
      const proto::View view = wanderer.next();
      senders[0].showAt(epochs.first());
      senders[1].showAt(epochs.first() + Duration{static_cast<int64_t>(
                                             rng.below(static_cast<uint64_t>((epochs.last() - epochs.first()).us)))});
      std::array<KeyframeMesh, 2> meshes;
      for (size_t end = 0; end < 2; ++end) {
        Bytes message;
        senders[end].send(view, Time::seconds(i), scratch, message);
        ASSERT_TRUE(replicas[end]
                        .apply(senders[end].keyframe(), ByteSpan(message).subspan(senders[end].headerBytes()),
                               i % 2 == 0 ? Blend::kKeyframe : Blend::kGeomorph)
                        .ok());
        meshes[end] = oracle::wholeMesh(replicas[end]);
      }
      const auto& [still, moving] = meshes;
      ASSERT_EQ(moving.parameters, still.parameters);
      for (size_t v = 0; v < moving.parameters.size(); ++v) {
        ASSERT_EQ(still.from_moved[v], 0);
        ASSERT_NEAR(moving.from_positions[v].w - moving.from_moved[v], still.from_positions[v].w, 1e-3);
        ASSERT_NEAR(moving.to_positions[v].w - moving.to_moved[v], still.to_positions[v].w, 1e-3);
        max_m = std::max(max_m, std::fabs(double{moving.to_moved[v]}));
      }
    }
  }
  EXPECT_GT(max_m, 5);
}

}  // namespace
}  // namespace foreland::test
