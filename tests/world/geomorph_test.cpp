// Geomorphs, from the server's records to the client's mesh: what is drawn has each node's weight, never jumps where it
// is seen, has no cracks, and comes to rest at the section.
#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <optional>

#include "client/replica.h"
#include "oracle/crack_checker.h"
#include "oracle/reference/whole_mesh.h"
#include "proto/topology/mesh_triangles.h"
#include "server/section/sender.h"
#include "server/session/world.h"
#include "sim/world.h"
#include "tests/support/lattice_surface.h"
#include "tests/support/scene.h"
#include "tests/support/wanderer.h"
#include "tests/world/ring_of_objects.h"

namespace foreland::test {
namespace {

using sim::ClientOptions;
using sim::onKnownTour;
using sim::World;

using client::Blend;
using client::KeyframeMesh;
using client::Morph;
using client::Morphs;
using proto::NodeId;

// Positions of meshes are floats, about an origin up to a few kilometres away.
constexpr double kRounding_m = 2e-3;

// p_w(v) as THEORY section 2 has it, of every node whether it is drawn or not. `own(v)` is its true position.
template <class Topology, class Own>
class Weighted {
 public:
  Weighted(const Topology& topology, const proto::Section& section, const Morphs& morphs, double Morph::*end, Own own)
      : topology_(topology), own_(std::move(own)) {
    for (proto::Slot slot : section.slots) weight_[slot] = 1;
    for (const Morph& m : morphs.all()) weight_[m.slot] = m.*end;
  }

  double weight(NodeId n) const {
    const auto it = weight_.find(topology_.slot(n));
    return it == weight_.end() ? 0 : it->second;
  }
  bool isDrawn(NodeId n) const {
    if (weight(n) > 0) return true;
    for (NodeId child : topology_.children(n))
      if (isDrawn(child)) return true;
    return false;
  }
  glm::dvec3 at(NodeId v) {
    if (topology_.isBase(v)) return own_(v);
    if (const auto it = known_.find(v); it != known_.end()) return it->second;
    const auto [a, b] = topology_.endpoints(v);
    const glm::dvec3 displacement = own_(v) - 0.5 * (own_(a) + own_(b));
    return known_[v] = 0.5 * (at(a) + at(b)) + weight(v) * displacement;
  }

 private:
  const Topology& topology_;
  Own own_;
  std::unordered_map<proto::Slot, double> weight_;
  std::unordered_map<NodeId, glm::dvec3> known_;
};

// Not between the planes of the view, whatever lies before it.
bool isOutside(const proto::View& view, const glm::dvec3& p) {
  const glm::dvec3 v = glm::conjugate(view.pose.orientation) * (p - view.pose.eye);
  const double tan_y = std::tan(0.5 * view.lens.vertical_fov_rad);
  return v.z > 0 || std::fabs(v.y) > -v.z * tan_y ||
         std::fabs(v.x) > -v.z * tan_y * view.lens.width_px / view.lens.height_px;
}

// A camera that looks around over a scene and mostly moves little: then changes take their time.
class Onlooker {
 public:
  Onlooker(const server::Hierarchy& h, uint64_t seed) : hierarchy_(h), rng_(seed) { jump(); }

  proto::View next() {
    const uint64_t what = rng_.below(10);
    if (what == 0) jump();
    if (what == 1) yaw_ += rng_.uniform(-2, 2);
    if (what == 2) tau_px_ = std::exp2(rng_.uniform(-2, 3));
    if (what == 3) ball_m_ = rng_.uniform(0, 20), turn_rad_ = rng_.uniform(0, 0.2);
    place_ += glm::dvec2(rng_.uniform(-0.3, 0.3), rng_.uniform(-0.3, 0.3));
    yaw_ += rng_.uniform(-0.01, 0.01);
    proto::View view = viewAt(hierarchy_, place_.x, place_.y, height_m_, yaw_, pitch_);
    view.tau_px = tau_px_, view.region_radius_m = ball_m_, view.region_angle_rad = turn_rad_;
    return view;
  }

 private:
  void jump() {
    const proto::GridShape& shape = hierarchy_.grid().shape();
    place_ = {rng_.uniform(0.2, 0.8) * shape.samples_x, rng_.uniform(0.2, 0.8) * shape.samples_y};
    height_m_ = rng_.uniform(900, 2500), yaw_ = rng_.uniform(0, 6.28), pitch_ = rng_.uniform(-1.2, -0.3);
  }

  const server::Hierarchy& hierarchy_;
  Rng rng_;
  glm::dvec2 place_{0};
  double height_m_ = 0, yaw_ = 0, pitch_ = 0, tau_px_ = 1, ball_m_ = 0, turn_rad_ = 0;
};

// At a point on one of ring_of_objects.h's spheres, whose facets, which are what faces away, turn a few degrees from
// it.
bool facesAway(const proto::ObjectPlacement& sphere, const glm::dvec3& p, const glm::dvec3& eye) {
  return glm::dot(glm::normalize(p - sphere.position), glm::normalize(eye - p)) < 0.14;
}

// A server and a replica without a session between them: any view after any other, at any time.
class Geomorphs : public testing::Test {
 protected:
  void fly(proto::FrameKind kind) {
    scene_ = makeScene(150, 110, 31, kind);
    hierarchy_.emplace(scene_, proto::ErrorBound::kSpheroid, objectsIn(*scene_, 6));
    sender_.emplace(*hierarchy_);
    replica_.emplace(server::welcomeTo(*hierarchy_));
  }

  void keyframe(const proto::View& view, Duration interval, Blend blend) {
    now_ = now_ + interval;
    Bytes message;
    sender_->send(view, now_, scratch_, message);
    const auto status = replica_->apply(sender_->keyframe(), ByteSpan(message).subspan(sender_->headerBytes()), blend);
    CHECK_TRUE(status.ok());
  }

  Duration anyInterval() { return Duration::milliseconds(20 + static_cast<int64_t>(rng_.below(400))); }

  // Each sample at each end where the weights have it; true positions are the scene's own.
  void expectWeighted(const KeyframeMesh& mesh) {
    const proto::GridTopology& grid = hierarchy_->grid();
    const auto own = [&](NodeId v) { return hierarchy_->frame().position(v, scene_->height(v)); };
    for (auto [end, weight] : {std::pair(&Morph::from, 0.0), std::pair(&Morph::to, 1.0)}) {
      Weighted reference(grid, replica_->section(), replica_->morphs(), end, own);
      const LatticeSurface drawn(mesh, weight, grid.shape());
      for (uint32_t y = 0; y < grid.shape().samples_y; ++y)
        for (uint32_t x = 0; x < grid.shape().samples_x; ++x)
          ASSERT_LT(glm::distance(drawn.at(x, y), reference.at(NodeId::at(x, y))), kRounding_m)
              << x << ' ' << y << " at " << weight;
    }
  }

  const uint64_t seed_ = testing::UnitTest::GetInstance()->random_seed();
  Rng rng_{seed_};
  std::shared_ptr<const terrain::Scene> scene_;
  std::optional<server::Hierarchy> hierarchy_;
  std::optional<server::SectionSender> sender_;
  std::optional<client::Replica> replica_;
  server::SendScratch scratch_;
  Time now_ = Time::seconds(1);
};

TEST_F(Geomorphs, AreDrawnAsTheWeightsHaveThemAndWithoutCracks) {
  SCOPED_TRACE("seed " + std::to_string(seed_));
  for (proto::FrameKind kind : {proto::FrameKind::kPlanar, proto::FrameKind::kGeographic}) {
    fly(kind);
    Onlooker onlooker(*hierarchy_, seed_);
    size_t between = 0;
    for (int i = 0; i < 60; ++i) {
      keyframe(onlooker.next(), anyInterval(), rng_.below(8) == 0 ? Blend::kKeyframe : Blend::kGeomorph);
      if (rng_.below(4) == 0) replica_->extend(anyInterval(), Blend::kGeomorph);
      const KeyframeMesh mesh = oracle::wholeMesh(*replica_);
      const oracle::CrackReport cracks = oracle::findCracks(mesh, scene_->grid().shape());
      ASSERT_EQ(cracks.cracks, 0u) << cracks.first;
      ASSERT_NO_FATAL_FAILURE(expectWeighted(mesh)) << "step " << i;
      for (const Morph& m : replica_->morphs().all()) between += !m.isDone();
    }
    EXPECT_GT(between, 50u) << "nothing was on its way";
  }
}

TEST_F(Geomorphs, NeverJumpWhereTheyAreSeen) {
  SCOPED_TRACE("seed " + std::to_string(seed_));
  fly(proto::FrameKind::kPlanar);
  Onlooker onlooker(*hierarchy_, seed_ + 1);
  const proto::GridShape& shape = scene_->grid().shape();
  std::optional<LatticeSurface> last;
  size_t jumped = 0;
  for (int i = 0; i < 60; ++i) {
    if (i > 0 && rng_.below(4) == 0)
      replica_->extend(anyInterval(), Blend::kGeomorph);
    else
      keyframe(onlooker.next(), anyInterval(), rng_.below(8) == 0 ? Blend::kKeyframe : Blend::kGeomorph);
    const KeyframeMesh mesh = oracle::wholeMesh(*replica_);
    const LatticeSurface begin(mesh, 0, shape);
    for (uint32_t y = 0; last && y < shape.samples_y; ++y)
      for (uint32_t x = 0; x < shape.samples_x; ++x) {
        const glm::dvec3 &p = last->at(x, y), &q = begin.at(x, y);
        if (glm::distance(p, q) < kRounding_m) continue;
        ++jumped;
        const proto::View view = proto::viewOf(mesh.from);
        ASSERT_TRUE(isOutside(view, p) && isOutside(view, q)) << x << ' ' << y << " at step " << i;
      }
    last.emplace(mesh, 1, shape);
  }
  EXPECT_GT(jumped, 10u) << "everything takes its time, seen or not";
}

// Objects as the weights have them, triangle by triangle. What jumps is outside the view or, on a sphere, faces away.
TEST_F(Geomorphs, OfObjectsAreDrawnAsTheWeightsHaveThem) {
  SCOPED_TRACE("seed " + std::to_string(seed_));
  fly(proto::FrameKind::kPlanar);
  Onlooker onlooker(*hierarchy_, seed_ + 2);
  size_t between = 0, jumped = 0, turned_away = 0;
  std::map<std::pair<size_t, proto::Slot>, double> last;            // weights
  for (int i = 0; i < 60 || (turned_away == 0 && i < 2000); ++i) {  // until something has turned away in view
    keyframe(onlooker.next(), anyInterval(), rng_.below(8) == 0 ? Blend::kKeyframe : Blend::kGeomorph);
    const KeyframeMesh mesh = oracle::wholeMesh(*replica_);
    const proto::View view = proto::viewOf(mesh.from);
    const proto::ObjectSet& set = hierarchy_->objects().set;
    size_t at = 0;
    for (size_t object = 0; object < set.size(); ++object) {
      const terrain::TrueSurface& surface = models().surfaces[set.placement(object).model];
      const client::ObjectReplica& held = replica_->objects()[object];
      const auto own = [&](NodeId v) { return set.placement(object).toScene(surface.position(v)); };
      Weighted from(surface.topology, held.section(), held.morphs(), &Morph::from, own);
      Weighted to(surface.topology, held.section(), held.morphs(), &Morph::to, own);
      for (const Morph& m : held.morphs().all()) {
        between += !m.isDone();
        const double before = std::exchange(last[{object, m.slot}], m.to);
        if (i == 0 || m.from == before) continue;
        ++jumped;
        if (set.placement(object).model != 0) continue;  // coarse tori have folds
        const glm::dvec3 p = own(surface.topology.node(m.slot));
        ASSERT_TRUE(isOutside(view, p) || facesAway(set.placement(object), p, view.pose.eye))
            << "object " << object << ", step " << i;
        turned_away += !isOutside(view, p);
      }
      const auto expectCorner = [&](NodeId v) {
        const uint32_t drawn = mesh.objects.indices[at++];
        ASSERT_LT(glm::distance(mesh.origin + glm::dvec3(mesh.objects.from_positions[drawn]), from.at(v)), 0.01);
        ASSERT_LT(glm::distance(mesh.origin + glm::dvec3(mesh.objects.to_positions[drawn]), to.at(v)), 0.01);
      };
      proto::forEachTriangle(
          surface.topology, [&](NodeId n) { return from.isDrawn(n) || to.isDrawn(n); },
          [&](NodeId a, NodeId b, NodeId c) {
            for (NodeId v : {a, b, c}) expectCorner(v);
          });
      ASSERT_FALSE(HasFatalFailure()) << "object " << object << ", step " << i;
    }
    ASSERT_EQ(at, mesh.objects.indices.size());
  }
  EXPECT_GT(between, 10u);
  EXPECT_GT(jumped, 0u);
  EXPECT_GT(turned_away, 0u) << "what faces away takes its time";
}

struct Flight {
  proto::Strategy strategy;
  proto::Predictor predictor;
  const char* tour;
  bool switches;  // to keyframes and back, now and then
};

void PrintTo(const Flight& f, std::ostream* out) {
  *out << proto::name(f.strategy) << ' ' << f.tour << (f.switches ? ", switching" : "");
}

ClientOptions geomorphing(const terrain::Scene& scene, const Flight& flight) {
  ClientOptions c = onKnownTour(scene, flight.tour, 60);
  c.request.strategy = flight.strategy;
  c.request.predictor = flight.predictor;
  c.announce_path = flight.predictor == proto::Predictor::kKnownPath;
  c.at_frame = [flight](client::Viewer& viewer, Time now) {
    viewer.setBlend(flight.switches && now.us / 1'500'000 % 2 == 1 ? Blend::kKeyframe : Blend::kGeomorph);
  };
  return c;
}

class GeomorphFlight : public testing::TestWithParam<Flight> {};

// From where the camera is in the very frame.
TEST_P(GeomorphFlight, DoesNotJumpBeforeTheCameraAndHasNoCracks) {
  const auto scene = makeScene(301, 217, 11);
  const proto::GridShape& shape = scene->grid().shape();
  World world(scene, {}, Duration::milliseconds(4), 1);
  const ClientOptions options = geomorphing(*scene, GetParam());
  world.addClient(options);
  uint32_t version = 0;
  uint64_t cracks = 0, between = 0;
  std::optional<LatticeSurface> last;
  world.on_frame = [&](size_t, const client::FrameView& view, Time now) {
    if (std::exchange(version, view.mesh_version) == view.mesh_version) return;
    if (version % 5 == 0) cracks += oracle::findCracks(*view.mesh, shape).cracks;
    for (const Morph& m : world.viewer(0).replica()->morphs().all()) between += !m.isDone();
    const LatticeSurface begin(*view.mesh, 0, shape);
    for (uint32_t y = 0; last && y < shape.samples_y; ++y)
      for (uint32_t x = 0; x < shape.samples_x; ++x) {
        if (glm::distance(last->at(x, y), begin.at(x, y)) < kRounding_m) continue;
        ASSERT_TRUE(isOutside({view.pose, options.request.lens}, last->at(x, y))) << now.toSeconds() << " s";
        ASSERT_TRUE(isOutside({view.pose, options.request.lens}, begin.at(x, y))) << now.toSeconds() << " s";
      }
    last.emplace(*view.mesh, 1, shape);
  };
  world.run(Time::seconds(10));
  EXPECT_EQ(world.report(), "");
  EXPECT_EQ(cracks, 0u);
  EXPECT_GT(between, 100u);
}

using proto::Predictor;
using proto::Strategy;
INSTANTIATE_TEST_SUITE_P(World, GeomorphFlight,
                         testing::Values(Flight{Strategy::kPredict, Predictor::kKnownPath, "survey", false},
                                         Flight{Strategy::kPredict, Predictor::kKnownPath, "spin", false},
                                         Flight{Strategy::kPredict, Predictor::kKnownPath, "canyon", true},
                                         Flight{Strategy::kDelay, Predictor::kHold, "canyon", false}));

TEST(GeomorphWorld, ComesToRestAtTheSectionWhenNoKeyframeComes) {
  const auto scene = makeScene(301, 217, 11);
  World world(scene, {}, Duration::milliseconds(4), 1, objectsIn(*scene, 6));
  world.addClient(geomorphing(*scene, {Strategy::kPredict, Predictor::kKnownPath, "canyon", false}));
  bool was_in_transition = false;
  uint32_t version = 0;
  Time changed;
  world.on_frame = [&](size_t, const client::FrameView& view, Time now) {
    was_in_transition = was_in_transition || world.viewer(0).replica()->isInTransition();
    if (std::exchange(version, view.mesh_version) != view.mesh_version) changed = now;
  };
  world.run(Time::seconds(5));
  EXPECT_TRUE(was_in_transition);
  world.loseConnection(0);
  world.run(Time::seconds(8));
  const client::Replica& replica = *world.viewer(0).replica();
  EXPECT_FALSE(replica.isInTransition());
  EXPECT_GT(changed, Time::seconds(5.4)) << "nothing went on";
  EXPECT_LT(changed, Time::seconds(7.2)) << "still at it";
  EXPECT_EQ(replica.section(), replica.nodes().newest()) << "something is drawn that has gone";
  world.connectAgain(0);
  world.run(Time::seconds(10));
  EXPECT_EQ(world.report(), "");
}

}  // namespace
}  // namespace foreland::test
