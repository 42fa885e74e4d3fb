// Blending of orders 2 and 3, from the server's records to the frames: a mesh is the blend of the last keyframes'
// sections, comes to rest at the section, and where meshes meet nothing changes its velocity at once.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <deque>
#include <optional>

#include "client/replica.h"
#include "oracle/crack_checker.h"
#include "oracle/reference/order_blend.h"
#include "oracle/reference/whole_mesh.h"
#include "server/section/sender.h"
#include "server/session/world.h"
#include "sim/world.h"
#include "tests/support/lattice_surface.h"
#include "tests/support/scene.h"
#include "tests/support/seed.h"
#include "tests/support/wanderer.h"

namespace foreland::test {
namespace {

using client::Blend;
using client::KeyframeMesh;
using sim::ClientOptions;
using sim::onKnownTour;
using sim::World;

constexpr Blend kSplines[] = {Blend::kSpline2, Blend::kSpline3};
// Positions of meshes are floats, about an origin up to a few kilometres away.
constexpr double kRounding_m = 3e-3;

// A server and a replica without a session between them, and the last keyframes' sections.
class Orders : public testing::Test {
 protected:
  void begin(std::shared_ptr<const terrain::Scene> scene) {
    scene_ = std::move(scene);
    hierarchy_.emplace(scene_);
    sender_.emplace(*hierarchy_);
    replica_.emplace(server::welcomeTo(*hierarchy_));
    keyframes_.clear();
  }

  void keyframe(const proto::View& view, Blend blend) {
    now_ = now_ + Duration::milliseconds(200);
    Bytes message;
    sender_->send(view, now_, scratch_, message);
    const auto status = replica_->apply(sender_->keyframe(), ByteSpan(message).subspan(sender_->headerBytes()), blend);
    CHECK_TRUE(status.ok());
    note();
  }
  void note() {
    if (keyframes_.empty()) keyframes_.assign(proto::kMaxOrder, {replica_->section(), {}});
    keyframes_.push_back({replica_->section(), {}});
    if (keyframes_.size() > proto::kMaxOrder + 1) keyframes_.pop_front();
  }

  // The last order + 1 keyframes, by the reference.
  KeyframeMesh reference(uint32_t order, double u, const glm::dvec3& origin) const {
    const std::vector<oracle::BlendedKeyframe> last(keyframes_.end() - order - 1, keyframes_.end());
    const oracle::OrderMesh blended = oracle::blendSections(
        hierarchy_->domain(), {scene_->cornerHeights(), scene_->centreHeights()},
        [this](proto::Slot slot) { return hierarchy_->nodes()[slot]; }, nullptr, last, origin);
    const auto weights = oracle::basisWeights(oracle::Basis::kBSpline, static_cast<int>(order), u);
    KeyframeMesh mesh;
    mesh.origin = blended.origin;
    mesh.parameters = blended.parameters;
    mesh.indices = blended.indices;
    for (size_t v = 0; v < mesh.parameters.size(); ++v) mesh.from_positions.emplace_back(blended.at(v, weights));
    mesh.to_positions = mesh.from_positions;
    return mesh;
  }

  const uint64_t seed_ = randomSeed();
  Rng rng_{seed_};
  std::shared_ptr<const terrain::Scene> scene_;
  std::optional<server::Hierarchy> hierarchy_;
  std::optional<server::SectionSender> sender_;
  std::optional<client::Replica> replica_;
  server::SendScratch scratch_;
  std::deque<oracle::BlendedKeyframe> keyframes_;
  Time now_ = Time::seconds(1);
};

void expectSameSurface(const KeyframeMesh& mesh, double weight, const KeyframeMesh& expected,
                       const proto::GridShape& shape) {
  const LatticeSurface drawn(mesh, weight, shape), wanted(expected, 0, shape);
  for (uint32_t y = 0; y < shape.samples_y; ++y)
    for (uint32_t x = 0; x < shape.samples_x; ++x)
      ASSERT_LT(glm::distance(drawn.at(x, y), wanted.at(x, y)), kRounding_m) << x << ' ' << y << " at " << weight;
}

TEST_F(Orders, AMeshIsTheBlendOfTheLastKeyframesAndWatertight) {
  SCOPED_TRACE(seed_);
  size_t bent = 0;
  for (proto::FrameKind kind : {proto::FrameKind::kPlanar, proto::FrameKind::kGeographic})
    for (Blend blend : kSplines) {
      begin(makeScene(90, 70, rng_.next(), kind));
      Wanderer wanderer(*hierarchy_, rng_.next());
      for (int i = 0; i < 25; ++i) {
        if (i > 0 && rng_.below(5) == 0) {
          replica_->extend(Duration::milliseconds(250), blend);
          note();
        } else {
          keyframe(wanderer.next(), blend);
        }
        const KeyframeMesh mesh = oracle::wholeMesh(*replica_);
        const oracle::CrackReport cracks = oracle::findCracks(mesh, hierarchy_->grid().shape());
        ASSERT_EQ(cracks.cracks, 0u) << cracks.first;
        for (double u : {0.0, 0.4, 1.0})
          ASSERT_NO_FATAL_FAILURE(
              expectSameSurface(mesh, u, reference(client::orderOf(blend), u, mesh.origin), hierarchy_->grid().shape()))
              << client::name(blend) << ", mesh " << i;
        bent += static_cast<size_t>(std::ranges::count_if(mesh.from_bends, [](auto& b) { return b != glm::vec3(0); }));
      }
    }
  EXPECT_GT(bent, 100u);
}

TEST_F(Orders, OfEqualKeyframesAreThatKeyframe) {
  SCOPED_TRACE(seed_);
  begin(makeScene(90, 70, rng_.next()));
  Wanderer wanderer(*hierarchy_, rng_.next());
  for (Blend blend : kSplines) {
    keyframe(wanderer.next(), blend);
    const proto::View view = wanderer.next();
    for (uint32_t i = 0; i <= client::orderOf(blend); ++i) keyframe(view, blend);
    const KeyframeMesh mesh = oracle::wholeMesh(*replica_);
    EXPECT_FALSE(replica_->isInTransition());
    EXPECT_EQ(mesh.from_positions, mesh.to_positions);
    for (size_t v = 0; v < mesh.from_bends.size(); ++v)
      ASSERT_TRUE(mesh.from_bends[v] == glm::vec3(0) && mesh.to_bends[v] == glm::vec3(0));
    keyframe(view, Blend::kKeyframe);
    const KeyframeMesh linear = oracle::wholeMesh(*replica_);
    EXPECT_EQ(mesh.to_positions, linear.to_positions);
    EXPECT_EQ(mesh.indices, linear.indices);
  }
}

// Whatever the orders: what a mesh ends with is what the next one begins with, and the times that they show likewise.
TEST_F(Orders, AreChangedInFlightWithoutAJump) {
  SCOPED_TRACE(seed_);
  begin(makeScene(90, 70, rng_.next()));
  Wanderer wanderer(*hierarchy_, rng_.next());
  const proto::GridShape& shape = hierarchy_->grid().shape();
  constexpr Blend kGuaranteed[] = {Blend::kKeyframe, Blend::kSpline2, Blend::kSpline3};
  std::optional<LatticeSurface> last;
  Time shown_until;
  for (int i = 0; i < 60; ++i) {
    keyframe(wanderer.next(), kGuaranteed[rng_.below(3)]);
    const KeyframeMesh mesh = oracle::wholeMesh(*replica_);
    const Time from = mesh.from.time - mesh.earlier.from_age, to = mesh.to.time - mesh.earlier.to_age;
    ASSERT_LE(from, to);
    if (last) {
      ASSERT_EQ(from, shown_until);
      const LatticeSurface begins(mesh, 0, shape);
      for (uint32_t y = 0; y < shape.samples_y; ++y)
        for (uint32_t x = 0; x < shape.samples_x; ++x)
          ASSERT_LT(glm::distance(last->at(x, y), begins.at(x, y)), kRounding_m) << x << ' ' << y << " of mesh " << i;
    }
    shown_until = to;
    last.emplace(mesh, 1, shape);
  }
}

// Of one client in flight: how much the velocity of the surface changes where meshes meet, metres a second.
struct Joints {
  double max_m_per_s = 0;
  uint64_t count = 0, frames_outside = 0;
  uint32_t late_keyframes = 0;
  double max_triangles = 0;
};

Joints fly(Blend blend, proto::Strategy strategy) {
  const auto scene = makeScene(301, 217, 11);
  const proto::GridShape& shape = scene->grid().shape();
  World world(scene, {}, Duration::milliseconds(4), 1);
  ClientOptions options = onKnownTour(*scene, "survey", 60);
  options.request.strategy = strategy;
  options.at_frame = [blend](client::Viewer& viewer, Time) { viewer.setBlend(blend); };
  world.addClient(options);
  Joints joints;
  uint32_t version = 0;
  std::vector<glm::dvec3> ended;  // velocities by sample
  world.on_frame = [&](size_t, const client::FrameView& view, Time now) {
    if (now < Time::seconds(2)) return;  // the camera has begun to move without notice
    joints.frames_outside += std::isinf(view.tolerance_px);
    if (std::exchange(version, view.mesh_version) == view.mesh_version) return;
    constexpr double kMoment = 1.0 / 64;
    const KeyframeMesh& mesh = *view.mesh;
    const double seconds = (mesh.to.time - mesh.earlier.to_age - mesh.from.time + mesh.earlier.from_age).toSeconds();
    const LatticeSurface begin(mesh, 0, shape), next(mesh, kMoment, shape), before(mesh, 1 - kMoment, shape),
        end(mesh, 1, shape);
    const auto velocity = [&](const LatticeSurface& from, const LatticeSurface& to, uint32_t x, uint32_t y) {
      return (to.at(x, y) - from.at(x, y)) / (kMoment * seconds);
    };
    std::vector<glm::dvec3> ends;
    for (uint32_t y = 0; y < shape.samples_y; ++y)
      for (uint32_t x = 0; x < shape.samples_x; ++x) {
        if (!ended.empty()) {
          const glm::dvec3 jump = velocity(begin, next, x, y) - ended[ends.size()];
          joints.max_m_per_s = std::max(joints.max_m_per_s, glm::length(jump));
        }
        ends.push_back(velocity(before, end, x, y));
      }
    joints.count += !ended.empty();
    ended = std::move(ends);
  };
  world.run(Time::seconds(10));
  EXPECT_EQ(world.report(), "");
  joints.late_keyframes = world.viewer(0).statistics().late_keyframes;
  std::printf("%s, %s: %.3f m/s, %.0f nodes\n", client::name(blend), proto::name(strategy), joints.max_m_per_s,
              static_cast<double>(world.session(0).statistics().section_nodes));
  return joints;
}

// The paper's order: nothing changes its velocity at a keyframe, as far as a difference over a moment can tell, which
// sees a moment's acceleration as well.
TEST(OrderFlight, NothingChangesItsVelocityAtOnce) {
  for (proto::Strategy strategy : {proto::Strategy::kPredict, proto::Strategy::kDelay}) {
    const Joints linear = fly(Blend::kKeyframe, strategy);
    EXPECT_GT(linear.count, 30u);
    EXPECT_GT(linear.max_m_per_s, 1);
    for (Blend blend : kSplines) {
      const Joints spline = fly(blend, strategy);
      EXPECT_GT(spline.count, 30u);
      EXPECT_LT(spline.max_m_per_s, 0.1 * linear.max_m_per_s) << client::name(blend) << proto::name(strategy);
      EXPECT_LE(spline.frames_outside, linear.frames_outside + 15) << client::name(blend) << proto::name(strategy);
      EXPECT_LE(spline.late_keyframes, linear.late_keyframes + 1) << client::name(blend) << proto::name(strategy);
    }
  }
}

}  // namespace
}  // namespace foreland::test
