// What judges drawn tiles, the rivals that pull them, and the comparison of both with our own stream.
#include <gtest/gtest.h>

#include <limits>

#include "lab/drape/drape_flight.h"
#include "server/view/tour.h"
#include "tests/support/scene.h"

namespace foreland::lab {
namespace {

constexpr double kEndless = std::numeric_limits<double>::infinity();
const proto::Lens kLens{1.0471975511965976, 640, 360};

std::shared_ptr<const terrain::Scene> someScene() {
  static const auto scene = std::shared_ptr<const terrain::Scene>(test::makeScene(700, 600, 7));
  return scene;
}

proto::Path tour(double seconds) { return server::planTour(*someScene(), "canyon", seconds).value(); }

// All tiles of the levels from `finest` on.
sim::DrawnTiles allFrom(uint32_t finest) {
  const proto::TileLayer& layer = someScene()->tiles().layers()[0];
  sim::DrawnTiles tiles;
  for (uint32_t level = finest; level < layer.levels(); ++level)
    for (uint32_t y = 0; y < layer.tilesY(level); ++y)
      for (uint32_t x = 0; x < layer.tilesX(level); ++x)
        tiles[proto::TileId{0, static_cast<uint8_t>(level), x, y}.key()] = 0;
  return tiles;
}

TEST(Drape, CoarserTilesLookWorseAndTheirTexelsAreLarger) {
  auto judge = DrapeJudge::create(someScene(), kLens, {tour(20).at(Time::seconds(3))}, 2);
  ASSERT_TRUE(judge.ok()) << judge.error().message;
  LayerImage image(someScene(), 0);
  DrapeQuality finer;
  for (uint32_t finest = 0; finest < image.layer().levels(); ++finest) {
    judge->judge(0, image, allFrom(finest), kEndless);
    const DrapeQuality quality = judge->take();
    EXPECT_EQ(quality.not_drawn, 0u);
    if (finest == 0) {
      EXPECT_EQ(quality.blur_px_s, 0);
      EXPECT_GT(quality.psnr_db, 45);
    } else {
      EXPECT_LT(quality.psnr_db, finer.psnr_db) << finest;
      EXPECT_LT(quality.ssim, finer.ssim) << finest;
      EXPECT_GE(quality.blur_px_s, finer.blur_px_s) << finest;
    }
    if (finest > 1) { EXPECT_NEAR(quality.texel_px_max / finer.texel_px_max, 2, 1e-4) << finest; }
    finer = quality;
  }
  EXPECT_GT(finer.blur_px_s, 0);
  judge->judge(0, image, {}, kEndless);
  EXPECT_GT(judge->take().not_drawn, 0u);
}

TEST(Drape, ATileThatHasFadedWholeLooksLikeItsParent) {
  auto judge = DrapeJudge::create(someScene(), kLens, {tour(20).at(Time::seconds(3))}, 2);
  ASSERT_TRUE(judge.ok());
  LayerImage image(someScene(), 0);
  sim::DrawnTiles faded = allFrom(0);
  for (auto& [key, fade] : faded) fade = proto::TileId::of(key).level == 0 ? 1.0f : 0.0f;
  judge->judge(0, image, faded, kEndless);
  const DrapeQuality as_faded = judge->take();
  judge->judge(0, image, allFrom(1), kEndless);
  const DrapeQuality as_parents = judge->take();
  EXPECT_EQ(as_faded.psnr_db, as_parents.psnr_db);
  EXPECT_EQ(as_faded.texel_px_max, as_parents.texel_px_max);
}

TEST(Drape, PixelsJumpWhereTheirLevelChangesAtOnce) {
  auto judge = DrapeJudge::create(someScene(), kLens, {tour(20).at(Time::seconds(3))}, 2);
  ASSERT_TRUE(judge.ok());
  const LayerImage image(someScene(), 0);
  const auto jumped = [&](const sim::DrawnTiles& before, const sim::DrawnTiles& after) {
    judge->compare(0, image, before, after);
    return judge->take().jumped_pixels;
  };
  const sim::DrawnTiles fine = allFrom(0), coarse = allFrom(1);
  sim::DrawnTiles coming = fine, half = fine;
  for (auto& [key, fade] : coming) fade = proto::TileId::of(key).level == 0 ? 1.0f : 0.0f;
  for (auto& [key, fade] : half) fade = proto::TileId::of(key).level == 0 ? 0.5f : 0.0f;
  EXPECT_EQ(jumped(fine, fine), 0);
  EXPECT_EQ(jumped(coarse, coming), 0) << "what comes has faded to its parent";
  EXPECT_GT(jumped(coarse, fine), 0);
  EXPECT_EQ(jumped(coarse, fine), jumped(fine, coarse));
  EXPECT_GT(jumped(coming, half), 0);
  EXPECT_GE(jumped(fine, {}), jumped(fine, coarse));
  EXPECT_EQ(jumped({}, fine), 0) << "the first picture is no jump";
  EXPECT_LE(jumped(fine, {}), kLens.width_px * kLens.height_px);
}

TEST(Drape, TexelsOverWhatWasStatedAreCounted) {
  auto judge = DrapeJudge::create(someScene(), kLens, {tour(20).at(Time::seconds(3))}, 2);
  ASSERT_TRUE(judge.ok());
  LayerImage image(someScene(), 0);
  judge->judge(0, image, allFrom(1), kEndless);
  const DrapeQuality quality = judge->take();
  EXPECT_EQ(quality.over_stated, 0u);
  judge->judge(0, image, allFrom(1), 1.1 * quality.texel_px_max);
  EXPECT_EQ(judge->take().over_stated, 0u);
  judge->judge(0, image, allFrom(1), 0.9 * quality.texel_px_max);
  EXPECT_GT(judge->take().over_stated, 0u);
}

TEST(Drape, OursKeepsWhatItStatesAndRivalsGetFinerTilesForMoreBytes) {
  DrapeFlight flight{.scene = someScene(),
                     .world = std::make_shared<server::World>(someScene()),
                     .path = tour(20),
                     .seconds = 6,
                     .lens = kLens,
                     .links = sim::fixedLink(Duration::milliseconds(50))};
  flight.path.start = Time{} + kDrapeStanding;
  auto experiment = DrapeExperiment::create(flight, 2);
  ASSERT_TRUE(experiment.ok()) << experiment.error().message;
  const auto [ours, with] = experiment->flyOurs();
  EXPECT_GT(ours.bytes, 0u);
  EXPECT_GE(ours.bytes, ours.first_view_bytes);
  EXPECT_EQ(ours.quality.over_stated, 0u);
  EXPECT_EQ(ours.quality.blur_px_s, 0);
  EXPECT_EQ(ours.quality.not_drawn, 0u);
  EXPECT_EQ(ours.quality.jumped_pixels, 0);
  EXPECT_EQ(experiment->flyOurs().figures.bytes, ours.bytes) << "the same flight";
  const DrapeArrivals without = experiment->flyWithoutTiles();
  EXPECT_GT(without.first_picture_ms, 50);  // a round trip
  EXPECT_GE(with.first_picture_ms, without.first_picture_ms);
  EXPECT_LT(with.first_picture_ms, 1000);
  EXPECT_GE(with.tolerance_ms, with.first_picture_ms);
  EXPECT_LT(with.lateness_p99_ms, 1000);
  const DrapeFigures fine = experiment->pull(TileRule::kDistance, 0.5),
                     coarse = experiment->pull(TileRule::kDistance, 8);
  EXPECT_GT(fine.bytes, coarse.bytes);
  EXPECT_GT(fine.quality.psnr_db, coarse.quality.psnr_db);
  EXPECT_GT(fine.quality.jumped_pixels, 0);
}

}  // namespace
}  // namespace foreland::lab
