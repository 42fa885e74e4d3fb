// A flight low in a valley of a small planet, where most is hidden by ridges: both ends hold the same sections, less is
// sent, and in frames nothing is seen but ground that is where it is. Judged by rays on the mesh that is drawn and on
// the planet's finest triangles, which are found by the judge's own faces.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>

#include "sim/world.h"
#include "tests/support/globe_scene.h"
#include "tests/support/plain_planet.h"
#include "tests/support/seed.h"

namespace foreland::test {
namespace {

constexpr uint32_t kFaceLog2 = 8;
constexpr double kFlight_s = 9;

class Valley {
 public:
  explicit Valley(uint64_t seed)
      : seed_(seed),
        scene_(makeGlobeScene(kFaceLog2, [seed](const glm::dvec3& d) { return globeRidges(seed, d); })),
        transform_(scene_->frame()),
        plain_(*scene_) {
    const double middle = 0.5 * scene_->grid().rootSize();
    for (double y = middle - 40; y <= middle + 40; y += 2)
      for (double x = middle - 40; x <= middle + 40; x += 2)
        if (groundMetres({x, y}) < groundMetres(lowest_)) lowest_ = {x, y};
    const glm::dvec3 about = eyeAt(0);
    for (const Corners& t : plain_.triangles())
      if (glm::distance(t[0], about) < 9'000) near_.push_back(t);
  }

  // The ground rises to either side of it.
  sim::ClientOptions client() const {
    sim::ClientOptions options;
    options.request.lens = {1.05, 960, 540};
    options.request.tau_px = 1;
    options.request.predictor = proto::Predictor::kKnownPath;
    options.request.keyframe_interval = Duration::milliseconds(200);
    options.request.occlusion = true;
    options.path = {Time{}, Duration::milliseconds(500), {}};
    options.announce_path = true;
    for (int i = 0; i <= 2 * kFlight_s + 10; ++i) {
      const glm::dvec3 eye = eyeAt(0.1 * i), up = transform_.upAt(eye),
                       ahead = glm::normalize(eyeAt(0.1 * i + 1) - eye);
      options.path.poses.push_back(
          {eye, proto::lookAlong(ahead + 0.3 * std::sin(0.4 * i) * glm::cross(up, ahead), up)});
    }
    return options;
  }

  const std::shared_ptr<const terrain::Scene>& scene() const { return scene_; }
  const std::vector<Corners>& near() const { return near_; }

 private:
  double groundMetres(const glm::dvec2& lattice) const {
    return globeRidges(seed_, glm::normalize(transform_.toScene(proto::LatticePosition{lattice.x, lattice.y, 0})));
  }
  glm::dvec3 eyeAt(double steps) const {
    const glm::dvec2 at = lowest_ + glm::dvec2(steps, 0);
    return transform_.toScene(proto::LatticePosition{at.x, at.y, groundMetres(at) + 60});
  }

  uint64_t seed_;
  std::shared_ptr<const terrain::Scene> scene_;
  proto::FrameTransform transform_;
  PlainPlanet plain_;
  glm::dvec2 lowest_{0.5 * (1 << kFaceLog2)};
  std::vector<Corners> near_;
};

// The nearest of some triangles that a ray meets.
std::optional<double> nearestHit(const std::vector<Corners>& triangles, const glm::dvec3& eye, const glm::dvec3& end) {
  std::optional<double> nearest;
  for (const Corners& t : triangles)
    if (const auto share = meetPlainly(eye, end, t); share && (!nearest || *share < *nearest)) nearest = share;
  return nearest;
}

std::vector<Corners> drawnIn(const client::FrameView& view) {
  std::vector<Corners> drawn;
  const client::KeyframeMesh& mesh = *view.mesh;
  for (size_t k = 0; k + 2 < mesh.indices.size(); k += 3) {
    Corners t;
    for (size_t i = 0; i < 3; ++i) t[i] = mesh.origin + glm::dvec3(mesh.at(mesh.indices[k + i], view.weight));
    drawn.push_back(t);
  }
  return drawn;
}

struct ValleyFlight {
  uint64_t bytes = 0, nodes = 0, hits = 0;
  double worst = 0;  // of what rays meet first, how far from the true ground: tolerances
};

ValleyFlight fly(const Valley& valley, server::Occlusion occlusion, uint64_t seed) {
  Rng rng(seed);
  auto shared = server::openWorld(valley.scene(), occlusion);
  sim::World world(
      *shared, {.occlusion = occlusion}, [](const sim::StepWork&) { return Duration::milliseconds(4); }, 1);
  const sim::ClientOptions options = valley.client();
  world.addClient(options);
  ValleyFlight flown;
  uint64_t frames = 0;
  world.on_frame = [&](size_t, const client::FrameView& view, Time) {
    if (frames++ % 97 != 40 || std::isinf(view.tolerance_px)) return;
    const std::vector<Corners> drawn = drawnIn(view);
    const glm::dvec3 eye = view.pose.eye, ahead = view.pose.orientation * glm::dvec3(0, 0, -1);
    for (int ray = 0; ray < 60; ++ray) {
      const glm::dvec3 off(rng.uniform(-1, 1), rng.uniform(-1, 1), rng.uniform(-1, 1)),
          end = eye + 8'000.0 * glm::normalize(ahead + 0.45 * off);
      const auto share = nearestHit(drawn, eye, end);
      if (!share) continue;
      // Ground that is drawn where it is lies within the tolerance of a true triangle.
      const glm::dvec3 p = eye + *share * (end - eye);
      double off_m = 1e9;
      for (const Corners& t : valley.near())
        if (glm::distance(t[0], p) < 600) off_m = std::min(off_m, distanceTo(t, p));
      const double allowed_m = view.tolerance_px * glm::distance(eye, p) / options.request.lens.focalPx() + 0.02;
      flown.worst = std::max(flown.worst, off_m / allowed_m);
      ++flown.hits;
    }
  };
  world.on_keyframe = [&](size_t, const sim::ArrivedKeyframe& keyframe) {
    flown.bytes += keyframe.bytes;
    flown.nodes += world.viewer(0).replica()->section().slots.size();
  };
  world.run(Time::seconds(0.5 * kFlight_s));
  world.loseConnection(0);
  world.run(Time::seconds(0.5 * kFlight_s + 0.3));
  world.connectAgain(0);
  world.run(Time::seconds(kFlight_s));
  EXPECT_EQ(world.report(), "");
  return flown;
}

TEST(GlobeHidden, NothingIsSeenInAValleyButGroundThatIsThereAndLessIsSent) {
  const uint64_t seed = randomSeed();
  SCOPED_TRACE(testing::Message() << "seed " << seed);
  const Valley valley(seed);
  const ValleyFlight all = fly(valley, server::Occlusion::kOff, seed), seen = fly(valley, server::Occlusion::kOn, seed);
  EXPECT_GT(seen.hits, 60u);
  EXPECT_LE(seen.worst, 1.001);
  EXPECT_LE(all.worst, 1.001);
  EXPECT_GT(seen.worst, 0.01) << "a judge that sees nothing finds nothing";
  EXPECT_LT(seen.nodes, 0.8 * static_cast<double>(all.nodes));
  EXPECT_LT(seen.bytes, all.bytes);
}

}  // namespace
}  // namespace foreland::test
