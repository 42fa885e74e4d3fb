// What a session tells of a scene's vertical datum: its name and coarse undulations in the welcome, exact ones with
// heights of the ground.
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <vector>

#include "base/rng.h"
#include "server/session/session.h"
#include "tests/support/scene.h"
#include "tests/support/seed.h"

namespace foreland::server {
namespace {

constexpr uint32_t kColumns = 101, kRows = 61;

proto::VerticalDatum wavyGeoid() {
  proto::VerticalDatum datum{
      proto::ZeroSurface::kGeoid, "EGM96", "EGM96", {{0, 0}, {1, 1}, kColumns, kRows, {}, 0.001}};
  for (uint32_t y = 0; y < kRows; ++y)
    for (uint32_t x = 0; x < kColumns; ++x)
      datum.undulations.metres.push_back(static_cast<float>(50 + 0.1 * x + 2 * std::sin(0.2 * y) * std::cos(0.15 * x)));
  return datum;
}

std::shared_ptr<const World> worldWith(const proto::VerticalDatum& datum) {
  test::FormulaSource source(kColumns, kRows, test::hills(5));
  source.info().vertical = datum;
  return std::make_shared<const World>(test::makeScene(source));
}

// The welcome, and the answer to a question of the ground.
std::pair<proto::Welcome, proto::GroundReply> ask(const proto::VerticalDatum& datum,
                                                  const std::vector<glm::dvec2>& at) {
  Session session(worldWith(datum), {});
  SessionScratch scratch;
  std::vector<Bytes> out;
  EXPECT_TRUE(session.receive(proto::encode(proto::ViewRequest{}), Time{}).ok());
  session.step(Time{}, scratch, out);
  session.onDrained(Time{});
  EXPECT_TRUE(session.receive(proto::encode(proto::GroundRequest{3, at}), Time{}).ok());
  session.step(Time::seconds(1), scratch, out);
  if (out.size() != 2) return {};
  auto welcome = proto::decodeServerMessage(out[0]), ground = proto::decodeServerMessage(out[1]);
  EXPECT_TRUE(welcome.ok()) << welcome.error().message;
  EXPECT_TRUE(ground.ok()) << ground.error().message;
  return {std::get<proto::Welcome>(*welcome), std::get<proto::GroundReply>(*ground)};
}

TEST(SessionDatum, UndulationsComeWithHeightsAndWithinTheBoundInTheWelcome) {
  const proto::VerticalDatum datum = wavyGeoid();
  Rng rng(test::randomSeed());
  std::vector<glm::dvec2> at;
  for (int i = 0; i < 500; ++i) at.emplace_back(rng.uniform(0, kColumns - 1), rng.uniform(0, kRows - 1));
  const auto [welcome, ground] = ask(datum, at);
  EXPECT_EQ(welcome.vertical.name, "EGM96");
  EXPECT_EQ(welcome.vertical.zero_surface, proto::ZeroSurface::kGeoid);
  const proto::UndulationGrid& coarse = welcome.vertical.undulations;
  EXPECT_EQ(coarse.columns, proto::kMaxUndulationSide);
  ASSERT_EQ(ground.undulations_m.size(), at.size());
  for (size_t i = 0; i < at.size(); ++i) {
    EXPECT_NEAR(ground.undulations_m[i], datum.undulations.at(at[i]), 1e-5);
    EXPECT_NEAR(coarse.at(at[i]), datum.undulations.at(at[i]), coarse.max_error_m + 1e-5);
  }
}

TEST(SessionDatum, OfASceneThatStatesNoneCostsNothing) {
  const auto [welcome, ground] = ask({}, {{1, 2}});
  EXPECT_EQ(welcome.vertical.zero_surface, proto::ZeroSurface::kUnstated);
  EXPECT_TRUE(welcome.vertical.undulations.isEmpty());
  EXPECT_EQ(ground.heights_m.size(), 1u);
  EXPECT_TRUE(ground.undulations_m.empty());
}

TEST(SessionDatum, AWelcomeWithDamagedUndulationsIsRefused) {
  const auto isRefused = [](const auto& damage) {
    proto::Welcome wrong = welcomeTo(worldWith(wavyGeoid())->hierarchy);
    wrong.keyframe_interval = Duration::milliseconds(200);
    damage(wrong.vertical);
    return !proto::decodeServerMessage(proto::encode(wrong)).ok();
  };
  EXPECT_FALSE(isRefused([](proto::VerticalDatum&) {}));
  EXPECT_TRUE(isRefused([](proto::VerticalDatum& v) { v.undulations.metres.pop_back(); }));
  EXPECT_TRUE(isRefused([](proto::VerticalDatum& v) { v.undulations.metres[5] = std::nanf(""); }));
  EXPECT_TRUE(isRefused([](proto::VerticalDatum& v) { v.undulations.step.x = -1; }));
  EXPECT_TRUE(isRefused([](proto::VerticalDatum& v) { v.name.clear(); }));
  EXPECT_TRUE(isRefused([](proto::VerticalDatum& v) { v.undulations = wavyGeoid().undulations; })) << "too many";
  proto::GroundReply reply{1, {1, 2}, {50}};
  EXPECT_FALSE(proto::decodeServerMessage(proto::encode(reply)).ok()) << "fewer undulations than heights";
}

}  // namespace
}  // namespace foreland::server
