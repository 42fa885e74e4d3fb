// What is seen, asked in flight: the answers are those of the scene, whole and in order, and keyframes come as if
// nobody had asked.
#include <gtest/gtest.h>

#include <vector>

#include "server/sight/viewshed.h"
#include "server/view/tour.h"
#include "sim/world.h"
#include "tests/support/scene.h"

namespace foreland::test {
namespace {

using proto::ViewshedCell;

// Asks for a viewshed and for pairs again and again, and keeps what comes.
struct Asker {
  proto::ViewshedRequest viewshed{0, {150, 120}, 5, 0, 1500, 10, 0, {}};
  proto::SightRequest pairs{0, {}, proto::Above::kGround, 0, {}};
  std::optional<uint32_t> viewshed_id, pairs_id;
  std::vector<ViewshedCell> cells;
  std::vector<std::vector<ViewshedCell>> viewsheds;
  std::vector<proto::SightReply> replies;

  void atFrame(client::Viewer& viewer) {
    if (!viewer.isGreeted()) return;
    if (!viewshed_id) viewshed_id = viewer.requestViewshed(viewshed);
    if (!pairs_id) pairs_id = viewer.requestSight(pairs);
    while (auto reply = viewer.takeSight()) {
      EXPECT_EQ(reply->id, *pairs_id);
      replies.push_back(std::move(*reply));
      pairs_id.reset();
    }
    while (auto reply = viewer.takeViewshed()) take(*reply);
  }
  void take(const proto::ViewshedReply& reply) {
    EXPECT_EQ(reply.id, *viewshed_id);
    EXPECT_EQ(reply.error, "");
    EXPECT_EQ(reply.begin, cells.size());
    cells.insert(cells.end(), reply.cells.begin(), reply.cells.end());
    if (cells.size() < size_t{reply.columns} * reply.rows) return;
    viewsheds.push_back(std::exchange(cells, {}));
    viewshed_id.reset();
  }
};

sim::ClientOptions flying(const terrain::Scene& scene) {
  sim::ClientOptions client = sim::onKnownTour(scene, "survey", 60);
  client.up.latency = client.down.latency = Duration::milliseconds(20);
  return client;
}

TEST(Sight, IsAnsweredInFlightAndNoKeyframeIsLate) {
  const auto scene = makeScene(301, 241, 9);
  sim::World world(scene, {}, Duration::milliseconds(8), 5);  // each step, and so each slice, takes so long
  Asker asker;
  for (double x = 1; x < 250; x += 3) asker.pairs.ends.insert(asker.pairs.ends.end(), {{x, 100, 2}, {300 - x, 17, 0}});
  sim::ClientOptions asking = flying(*scene);
  asking.at_frame = [&](client::Viewer& viewer, Time) { asker.atFrame(viewer); };
  world.addClient(asking);
  world.addClient(flying(*scene));
  world.run(Time::seconds(30));
  EXPECT_EQ(world.report(), "");
  for (size_t i = 0; i < 2; ++i) {
    EXPECT_GE(world.viewer(i).statistics().keyframes, 29 * 4.9) << i;
    EXPECT_LE(world.viewer(i).statistics().late_keyframes, 1u) << i;
  }
  ASSERT_GE(asker.viewsheds.size(), 2u);
  ASSERT_GE(asker.replies.size(), 2u);

  const server::Hierarchy hierarchy(scene);
  const auto sight = server::SightScene::create(hierarchy).value();
  const server::ViewshedQuestion question{asker.viewshed.observer, 5, 0, 1500, 10, 0, Time{}};
  const server::Viewshed expected(sight, question, server::Viewshed::gridOf(hierarchy, question, 1u << 22).value());
  const server::ViewshedGrid& grid = expected.grid();
  ASSERT_EQ(asker.viewsheds[0].size(), grid.cells());
  for (size_t i = 0; i < grid.cells(); ++i)
    ASSERT_EQ(asker.viewsheds[0][i],
              expected.cell(static_cast<uint32_t>(i % grid.columns), static_cast<uint32_t>(i / grid.columns)));
  EXPECT_EQ(asker.viewsheds[0], asker.viewsheds[1]);
  const proto::SightReply& reply = asker.replies[0];
  for (size_t i = 0; i < reply.hits.size(); ++i)
    ASSERT_EQ(reply.hits[i].what == proto::SightHit::kNothing,
              sight->sees(reply.ends[2 * i], reply.ends[2 * i + 1], 0, sight->at(Time{})));
}

TEST(Sight, ThatIsCancelledComesNoFurther) {
  const auto scene = makeScene(301, 241, 9);
  sim::World world(scene, {}, Duration::milliseconds(8), 6);
  sim::ClientOptions asking = flying(*scene);
  uint32_t id = 0;
  size_t told = 0, cells = 0, told_later = 0;
  std::optional<Time> cancelled;
  asking.at_frame = [&](client::Viewer& viewer, Time now) {
    if (viewer.isGreeted() && id == 0) id = viewer.requestViewshed({0, {150, 120}, 5, 0, 5000, 10, 0, {}});
    while (const auto reply = viewer.takeViewshed()) {
      told += reply->cells.size();
      cells = size_t{reply->columns} * reply->rows;
      if (cancelled && now - *cancelled > Duration::milliseconds(500)) ++told_later;
    }
    if (told > 0 && !cancelled) viewer.cancelRequest(id), cancelled = now;
  };
  world.addClient(asking);
  world.run(Time::seconds(20));
  EXPECT_EQ(world.report(), "");
  EXPECT_LT(told, cells);
  EXPECT_EQ(told_later, 0u);
}

TEST(Sight, ThatCannotBeAnsweredSaysWhy) {
  const auto scene = makeScene(120, 90, 9);
  sim::World world(scene, {}, Duration::milliseconds(4), 7);
  sim::ClientOptions asking = flying(*scene);
  bool has_asked = false;
  std::vector<std::string> errors;
  asking.at_frame = [&](client::Viewer& viewer, Time) {
    if (viewer.isGreeted() && !std::exchange(has_asked, true))
      viewer.requestViewshed({0, {-5, 3}, 5, 0, 500, 10, 0, {}});
    while (const auto reply = viewer.takeViewshed()) {
      errors.push_back(reply->error);
      if (errors.size() == 1) viewer.requestViewshed({0, {50, 30}, 5, 0, 1000, 0.01, 0, {}});
    }
  };
  world.addClient(asking);
  world.run(Time::seconds(5));
  EXPECT_EQ(world.report(), "");
  ASSERT_EQ(errors.size(), 2u);
  EXPECT_NE(errors[0].find("beyond the data"), std::string::npos) << errors[0];
  EXPECT_NE(errors[1].find("4194304 cells"), std::string::npos) << errors[1];
}

}  // namespace
}  // namespace foreland::test
