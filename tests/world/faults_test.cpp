// Faults by seed: honest viewers fly, jump, turn and change their minds over links with latency, jitter, stalls and
// little rate, which cut, corrupt and lose what is on its way; new connections overtake the ends of old ones; servers
// are killed and replaced, or drained first, so that viewers are migrated; beside them hostile viewers say anything
// at any time, with time stamps that lie. The laws, in every scenario:
//
//   * every section that a viewer acknowledges is the same at both ends (World checks it);
//   * a frame that claims a tolerance keeps it: the section shown has all nodes that its camera needs at that tolerance;
//   * an honest viewer is never without a picture once it had one, and is at its tolerance again soon after the faults;
//   * a viewer that holds a section goes on from it on its next connection, whatever ended the last one (World);
//   * no section exceeds the limit of nodes, and what waits to be sent stays within its bounds, as does what a session
//     makes while nobody is at the other end (World).
//
//   FORELAND_FAULT_SEED=17 world_test --gtest_filter=*Faults*        one scenario
//   FORELAND_FAULT_SEEDS=10000 world_test --gtest_filter=*Faults*    many
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <glm/geometric.hpp>

#include "base/rng.h"
#include "server/view/ground.h"
#include "server/view/region_share.h"
#include "sim/world.h"
#include "tests/support/sanitized.h"
#include "tests/support/scene.h"
#include "tests/world/hostile_viewer.h"

namespace foreland::test {
namespace {

using sim::ClientOptions;
using sim::LinkOptions;
using sim::World;

constexpr size_t kMaxNodes = 20'000;
constexpr Duration kFaulty = Duration::seconds(6), kQuiet = Duration::seconds(5), kSettled = Duration::seconds(4);

const std::array<std::shared_ptr<const terrain::Scene>, 2>& scenes() {
  static const std::array<std::shared_ptr<const terrain::Scene>, 2> all{
      makeScene(161, 129, 3), makeScene(97, 145, 4, proto::FrameKind::kGeographic)};
  return all;
}

// A camera that flies straight for a while, and then turns, stops or jumps; the same for the same seed.
class Camera {
 public:
  Camera(const terrain::Scene& scene, uint64_t seed, bool jumps) : scene_(scene), rng_(seed), jumps_(jumps) {}

  // Times must not decrease.
  proto::Pose at(Time now) {
    if (!begun_) begin(now);
    while (now >= leg_end_ && now < quiet_from_) begin(leg_end_);
    const double s = (now - leg_begin_).toSeconds();
    const double heading = heading_ + turn_ * s;
    const glm::dvec3 forward(std::cos(heading), std::sin(heading), -0.5);
    return {eye_ + speed_ * s * glm::dvec3(std::cos(heading_), std::sin(heading_), 0),
            proto::lookAlong(glm::normalize(forward), {0, 0, 1})};
  }
  // From then on it goes on as it goes.
  void calmFrom(Time t) { quiet_from_ = t; }
  bool turns() const { return turn_ != 0; }

 private:
  void begin(Time now) {
    if (begun_) eye_ = at(Time{std::min(now.us, leg_end_.us) - 1}).eye;
    if (!begun_ || (jumps_ && rng_.below(2) == 0)) {
      eye_ = {rng_.uniform(-600, 600), rng_.uniform(-500, 500), 0};
      eye_.z = 4000 - server::heightAboveGround(scene_, {eye_.x, eye_.y, 4000}) + rng_.uniform(100, 900);
    }
    begun_ = true;
    heading_ = rng_.uniform(0, 6.28);
    speed_ = rng_.below(3) == 0 ? 0 : rng_.uniform(5, 80);
    turn_ = rng_.below(2) == 0 ? 0 : rng_.uniform(-0.6, 0.6);
    leg_begin_ = now;
    leg_end_ = now + Duration::seconds(rng_.uniform(0.3, 2.5));
  }

  const terrain::Scene& scene_;
  Rng rng_;
  bool jumps_, begun_ = false;
  glm::dvec3 eye_{0};
  double heading_ = 0, speed_ = 0, turn_ = 0;
  Time leg_begin_, leg_end_, quiet_from_{INT64_MAX};
};

LinkOptions anyLink(Rng& rng) {
  LinkOptions link;
  link.latency = Duration::milliseconds(static_cast<int64_t>(rng.below(120)));
  link.jitter = Duration::milliseconds(static_cast<int64_t>(rng.below(40)));
  if (rng.below(3) == 0) link.bytes_per_second = rng.uniform(20'000, 400'000);
  if (rng.below(4) == 0) {
    link.stall_every = Duration::seconds(rng.uniform(1, 4));
    link.stall = Duration::milliseconds(static_cast<int64_t>(50 + rng.below(400)));
  }
  return link;
}

ClientOptions honest(Rng& rng, Camera& camera) {
  ClientOptions c;
  c.request.lens = {1.0471975511965976, 200 + static_cast<uint32_t>(rng.below(120)), 160};
  c.request.tau_px = rng.uniform(0.7, 3);
  c.request.strategy = static_cast<proto::Strategy>(rng.below(3));
  // A camera that is expected to stand still outruns its regions whenever a link stalls.
  c.request.predictor =
      rng.below(2) == 0 ? proto::Predictor::kConstantVelocity : proto::Predictor::kConstantAcceleration;
  c.request.keyframe_interval = Duration::milliseconds(static_cast<int64_t>(100 + 50 * rng.below(4)));
  c.up = anyLink(rng);
  c.down = anyLink(rng);
  c.clock_offset = Duration::seconds(rng.uniform(-1e5, 1e5));
  c.corrupt_one_in = rng.below(3) == 0 ? 20 + rng.below(200) : 0;
  c.camera = [&camera](Time now) { return camera.at(now); };
  return c;
}

// Whether the newest section has all nodes that a camera needs at the tolerance that its frame claims.
bool keepsWhatItClaims(const World& world, size_t client, const client::FrameView& view) {
  static proto::RefineScratch scratch;
  const client::Replica& replica = *world.viewer(client).replica();
  // With `current` the claim is for the camera of then.
  if (world.viewer(client).request().strategy == proto::Strategy::kCurrent) return true;
  if (!(view.tolerance_px < 1e9f) || view.mesh->to.index != replica.newest().index || view.weight < 1) return true;
  const server::Hierarchy& hierarchy = world.session(client).world().hierarchy;
  proto::Section needed;
  proto::View at{view.pose, view.mesh->to.lens, view.tolerance_px};
  if (!server::refine(hierarchy, at, kMaxNodes, scratch, needed)) return false;
  const proto::Section section = replica.section();
  return std::includes(section.slots.begin(), section.slots.end(), needed.slots.begin(), needed.slots.end());
}

struct Scenario {
  explicit Scenario(uint64_t seed)
      : rng(seed), scene(scenes()[rng.below(2)]), world(scene, options(), Duration::milliseconds(3), seed) {
    const size_t viewers = 1 + rng.below(2);
    for (size_t i = 0; i < viewers; ++i) {
      cameras.push_back(std::make_unique<Camera>(*scene, rng.next(), rng.below(3) > 0));
      clients.push_back(honest(rng, *cameras.back()));
      cameras.back()->calmFrom(Time{} + kFaulty + clients.back().clock_offset);
      world.addClient(clients.back());
    }
    lost_until.resize(viewers);
    at_tau.resize(viewers, 0);
    guaranteed.resize(viewers, 0);
    quiet_frames.resize(viewers, 0);
    world.on_frame = [this](size_t i, const client::FrameView& view, Time now) { judge(i, view, now); };
  }

  static server::SessionOptions options() {
    server::SessionOptions options;
    options.max_section_nodes = kMaxNodes;
    options.max_added_nodes = 6000;
    options.max_added_after_jump = 2000;
    return options;
  }

  void judge(size_t i, const client::FrameView& view, Time now) {
    if (frames++ % 16 == 0 && !keepsWhatItClaims(world, i, view)) ++broken_claims;
    if (now - clients[i].clock_offset < Time{} + kFaulty + kSettled) return;
    const auto isHeld = [&](float tolerance_px, double times = 1) {
      return tolerance_px <= static_cast<float>(times * clients[i].request.tau_px) * 1.0001f;
    };
    // Turns that cannot be predicted are coarser.
    const double times = cameras[i]->turns() ? server::RegionShare::kCoarsest : 1;
    ++quiet_frames[i];
    at_tau[i] += isHeld(view.mesh->from.tau_px, times) && isHeld(view.mesh->to.tau_px, times);
    guaranteed[i] += isHeld(view.tolerance_px);
  }

  // Cuts, stalls, kills, drains and replaces, now and then.
  void fault(Time now) {
    for (size_t i = 0; i < clients.size(); ++i) {
      if (rng.below(80) == 0) world.stall(i, now + Duration::seconds(rng.uniform(0.1, 1.5)));
      world.isConnected(i) ? faultConnection(i) : connect(i, now);
    }
    const uint64_t chance = rng.below(240);
    if (chance < 2)  // the server is killed
      for (size_t i = 0; i < clients.size(); ++i)
        if (world.isConnected(i)) world.loseConnection(i);
    if (chance >= 2 && chance < 6)  // it is drained
      for (size_t i = 0; i < clients.size(); ++i)
        if (world.isConnected(i)) world.migrate(i);
  }
  void faultConnection(size_t i) {
    lost_until[i] = {};
    if (rng.below(50) == 0) return world.loseConnection(i);
    if (rng.below(80) == 0) return world.migrate(i);
    if (rng.below(80) == 0) return world.overtake(i, Duration::seconds(rng.uniform(0, 2)));
    if (rng.below(60) > 0) return;
    clients[i].request.tau_px = rng.uniform(0.7, 3);
    world.changeRequest(i, clients[i].request);
  }
  // One that was migrated may come back sooner, by itself.
  void connect(size_t i, Time now) {
    if (lost_until[i] == Time{}) lost_until[i] = now + Duration::seconds(rng.uniform(0, 1));
    if (now >= lost_until[i]) world.connectAgain(i);
  }

  void run() {
    Rng choices(rng.next());
    HostileViewer hostile(world.serverWorld(), options(), choices);
    for (Time now; now < Time{} + kFaulty; now = now + Duration::milliseconds(50)) {
      world.run(now);
      fault(now);
      hostile.act(now);
    }
    world.stopCorruption();
    for (size_t i = 0; i < clients.size(); ++i)
      if (!world.isConnected(i)) world.connectAgain(i);
    world.run(Time{} + kFaulty + Duration::milliseconds(400));
    for (size_t i = 0; i < clients.size(); ++i)
      if (!world.isConnected(i)) world.connectAgain(i);
    world.run(Time{} + kFaulty + kQuiet);
    EXPECT_EQ(world.report(), "");
    EXPECT_EQ(hostile.report(), "");
    EXPECT_EQ(broken_claims, 0u) << "of " << frames << " frames";
    for (size_t i = 0; i < clients.size(); ++i) {
      EXPECT_GT(quiet_frames[i], 50u) << "viewer " << i << " has no picture";
      // Links go on stalling, for up to half a second of the last one, and a keyframe that is late for that raises the
      // tolerance for a while. A camera that turns may outrun regions; its frames say so.
      EXPECT_GE(4 * at_tau[i], 3 * quiet_frames[i]) << "viewer " << i << " is not back at its tolerance";
      if (!cameras[i]->turns()) {
        EXPECT_GE(4 * guaranteed[i], quiet_frames[i]) << "viewer " << i << " has left the regions of its keyframes";
      }
      EXPECT_LE(world.session(i).statistics().section_nodes, kMaxNodes);
      EXPECT_LE(world.traffic(i).max_unsent_bytes, 2 * world.traffic(i).largest_down);
    }
  }

  Rng rng;
  std::shared_ptr<const terrain::Scene> scene;
  World world;
  std::vector<std::unique_ptr<Camera>> cameras;
  std::vector<ClientOptions> clients;
  std::vector<Time> lost_until;
  std::vector<uint64_t> at_tau, guaranteed, quiet_frames;
  uint64_t frames = 0, broken_claims = 0;
};

class Faults : public testing::TestWithParam<int> {};

constexpr int kParts = 4;

TEST_P(Faults, EveryScenarioKeepsTheLaws) {
  const char* one = std::getenv("FORELAND_FAULT_SEED");
  const char* many = std::getenv("FORELAND_FAULT_SEEDS");
  const uint64_t count = one ? 1 : many ? std::strtoull(many, nullptr, 10) : kIsSanitized ? 40 : 200;
  const uint64_t begin = one ? std::strtoull(one, nullptr, 10) : 1;
  for (uint64_t seed = begin; seed < begin + count; ++seed) {
    if (static_cast<int>(seed % kParts) != GetParam()) continue;
    SCOPED_TRACE("this scenario alone: FORELAND_FAULT_SEED=" + std::to_string(seed));
    Scenario(seed).run();
    if (HasFailure()) return;
  }
}

INSTANTIATE_TEST_SUITE_P(World, Faults, testing::Range(0, kParts));

}  // namespace
}  // namespace foreland::test
