// Scenes of several epochs: what the file says of each equals a scene that was built of that epoch alone, and bounds
// hold at all of them.
#include <gtest/gtest.h>

#include <cmath>
#include <cstring>

#include "terrain/store/file/sections.h"
#include "terrain/store/format.h"
#include "terrain/store/verify.h"
#include "tests/support/scene.h"
#include "tests/support/seed.h"

namespace foreland::terrain {
namespace {

using proto::LatticeWindow;
using proto::NodeId;

constexpr int64_t kDay_us = 86'400'000'000;

// Terrain and what it becomes, with the heights that it must have at each epoch.
struct Story {
  uint32_t width, height;
  std::vector<test::HeightFunction> ground;  // by epoch, everywhere
  std::vector<LatticeWindow> windows;

  // Epoch i changes its window only, by hills of another seed.
  static Story any(Rng& rng, size_t epochs) {
    Story s{static_cast<uint32_t>(20 + rng.below(60)), static_cast<uint32_t>(20 + rng.below(60)), {}, {}};
    test::HeightFunction before = test::hills(rng.next());
    for (size_t i = 0; i < epochs; ++i) {
      const auto x = static_cast<uint32_t>(rng.below(s.width)), y = static_cast<uint32_t>(rng.below(s.height));
      const LatticeWindow w{x, y, static_cast<uint32_t>(1 + rng.below(s.width - x)),
                            static_cast<uint32_t>(1 + rng.below(s.height - y))};
      const test::HeightFunction after = test::hills(rng.next());
      before = [=](uint32_t at_x, uint32_t at_y) { return (w.contains(at_x, at_y) ? after : before)(at_x, at_y); };
      s.ground.push_back(before);
      s.windows.push_back(w);
    }
    return s;
  }

  std::shared_ptr<const Scene> scene(proto::FrameKind kind,
                                     proto::EpochBlend blend = proto::EpochBlend::kLinear) const {
    test::FormulaSource base(width, height, ground[0], kind);
    std::vector<test::FormulaSource> sources;
    for (size_t i = 0; i < ground.size(); ++i) sources.push_back(test::windowSource(base, windows[i], ground[i]));
    std::vector<EpochRequest> requests;
    for (size_t i = 0; i < ground.size(); ++i)
      requests.push_back({Time{static_cast<int64_t>(i) * kDay_us}, std::to_string(i), &sources[i]});
    const test::TemporaryFolder folder;
    const auto built =
        buildScene(base, {.output = folder / "scene.fls", .threads = 2, .epochs = requests, .epoch_blend = blend});
    EXPECT_TRUE(built.ok()) << built.error().message;
    const auto verified = verifyScene(folder / "scene.fls");
    EXPECT_TRUE(verified.ok() && verified->sound()) << verified->first_faults.front();
    return *Scene::open(folder / "scene.fls");
  }
};

class EpochScenes : public ::testing::TestWithParam<proto::FrameKind> {};

TEST_P(EpochScenes, HaveTheGroundOfEachEpochAndBoundsThatHoldAtAll) {
  const uint64_t seed = test::randomSeed();
  SCOPED_TRACE(seed);
  Rng rng(seed);
  for (int trial = 0; trial < 6; ++trial) {
    const Story story = Story::any(rng, 2 + rng.below(5));
    const auto scene = story.scene(GetParam());
    const proto::GridTopology& grid = scene->grid();
    ASSERT_EQ(scene->epochs().epochs().size(), story.ground.size());
    for (uint32_t epoch = 0; epoch < story.ground.size(); ++epoch) {
      const auto alone = test::makeScene(story.width, story.height, story.ground[epoch], GetParam());
      uint64_t wrong = 0, loose = 0;
      for (uint32_t y = 0; y <= grid.maxY(); ++y)
        for (uint32_t x = 0; x <= grid.maxX(); ++x) {
          const NodeId v = NodeId::at(x, y);
          const int32_t offset = scene->epochs().offset(epoch, grid, v);
          if (scene->height(v) + offset != alone->height(v)) ++wrong;
          if (offset != 0 && !scene->epochs().epochs().mayMove(epoch, v)) ++wrong;
          if (grid.isBase(v)) continue;
          if (scene->node(v).error() < alone->node(v).error()) ++loose;
        }
      EXPECT_EQ(wrong, 0u) << "epoch " << epoch;
      EXPECT_EQ(loose, 0u) << "epoch " << epoch;
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Frames, EpochScenes,
                         ::testing::Values(proto::FrameKind::kPlanar, proto::FrameKind::kGeographic),
                         [](const auto& instance) {
                           return std::string(instance.param == proto::FrameKind::kPlanar ? "Planar" : "Geographic");
                         });

// At any scene time a node's error is at least that of a scene that was built of the ground then, as far as heights are
// rounded to quanta there.
TEST_P(EpochScenes, HaveBoundsThatHoldBetweenEpochs) {
  const uint64_t seed = test::randomSeed();
  SCOPED_TRACE(seed);
  Rng rng(seed);
  for (const proto::EpochBlend blend : {proto::EpochBlend::kCatmullRom, proto::EpochBlend::kBSpline})
    for (int trial = 0; trial < 3; ++trial) {
      const Story story = Story::any(rng, 2 + rng.below(5));
      const auto scene = story.scene(GetParam(), blend);
      const proto::GridTopology& grid = scene->grid();
      const proto::Epochs& epochs = scene->epochs().epochs();
      EXPECT_EQ(epochs.blend(), blend);
      for (int i = 0; i < 6; ++i) {
        const proto::EpochWeights weights = epochs.weightsAt(
            epochs.first() + Duration{static_cast<int64_t>(rng.uniform(0, static_cast<double>(epochs.last().us)))});
        const auto quanta = [&](NodeId v) {
          double sum = scene->height(v);
          for (uint32_t k = 0; k < weights.count; ++k)
            sum += weights.weight[k] * scene->epochs().offset(weights.epoch[k], grid, v);
          return sum;
        };
        constexpr double kFine = 256;  // steps to a quantum
        test::FormulaSource source(
            story.width, story.height,
            [&](uint32_t x, uint32_t y) { return quanta(NodeId::at(x, y)) * scene->frame().height_quantum_m; },
            GetParam());
        const double quantum_m = scene->frame().height_quantum_m;
        const auto alone = test::makeScene(source, quantum_m / kFine);
        uint64_t loose = 0;
        for (uint32_t y = 0; y <= grid.maxY(); ++y)
          for (uint32_t x = 0; x <= grid.maxX(); ++x) {
            const NodeId v = NodeId::at(x, y);
            if (grid.isBase(v)) continue;
            // The other's is rounded up, by less than a step of half an octave.
            const double min_m = alone->node(v).error().metres() / std::sqrt(2.0) - 2 * quantum_m / kFine;
            loose += scene->node(v).error().metres() < min_m ? 1 : 0;
            const double height = quanta(v), rounding = 1e-6;
            loose +=
                height < scene->heightRange().lowest - rounding || height > scene->heightRange().highest + rounding;
          }
        EXPECT_EQ(loose, 0u) << proto::name(blend);
      }
    }
}

// A linear scene has the bytes that it had before there were other blends; one of another blend is of a later version,
// and an unknown one is refused by what is wrong with it.
TEST(Epochs, HaveABlendInTheFile) {
  test::FormulaSource base(40, 30, test::hills(1)), other = test::windowSource(base, {5, 5, 20, 20}, test::hills(2));
  const test::TemporaryFolder folder;
  const auto built = [&](proto::EpochBlend blend) {
    EXPECT_TRUE(buildScene(base, {.output = folder / "a.fls",
                                  .epochs = {{Time{0}, "a", &base}, {Time{kDay_us}, "b", &other}},
                                  .epoch_blend = blend})
                    .ok());
    return test::slurp(folder / "a.fls");
  };
  const auto opened = [&](std::vector<char> bytes, uint32_t version, uint32_t blend) {
    FileHeader header;
    std::memcpy(&header, bytes.data(), sizeof(header));
    EXPECT_EQ(header.version, header.epoch_blend == 0 ? 4u : 5u);
    header.version = version;
    header.epoch_blend = blend;
    const SectionRange sums = header.sections[kChecksums];
    header.scene_id = contentId(header, {reinterpret_cast<const uint8_t*>(bytes.data()) + sums.offset, sums.bytes});
    header.header_checksum = headerChecksum(header);
    std::memcpy(bytes.data(), &header, sizeof(header));
    test::spit(folder / "b.fls", bytes);
    const auto scene = Scene::open(folder / "b.fls");
    return scene.ok() ? std::string(proto::name((*scene)->epochs().epochs().blend())) : scene.error().message;
  };
  for (uint32_t i = 0; i < 3; ++i) {
    const proto::EpochBlend blend = proto::epochBlendOf(i).value();
    const std::vector<char> bytes = built(blend);
    EXPECT_EQ(opened(bytes, i == 0 ? 4 : 5, i), proto::name(blend));
    EXPECT_NE(opened(bytes, 5, 3).find("blended in an unknown way"), std::string::npos);
    EXPECT_NE(opened(bytes, 4, 1).find("too old to blend"), std::string::npos);
  }
  const auto refused = buildScene(base, {.output = folder / "c.fls", .epoch_blend = proto::EpochBlend::kBSpline});
  ASSERT_FALSE(refused.ok());
  EXPECT_NE(refused.error().message.find("no epochs to blend"), std::string::npos);
}

// Outside of the windows bounds are those of a scene without epochs.
TEST(Epochs, CostNothingWhereNothingMoves) {
  test::FormulaSource base(200, 200, test::hills(4));
  const LatticeWindow w{20, 30, 12, 9};
  test::FormulaSource first = test::windowSource(base, w, test::hills(4)),
                      second = test::windowSource(base, w, test::hills(5));
  const test::TemporaryFolder folder;
  const std::vector<EpochRequest> epochs{{Time{0}, "a", &first}, {Time{kDay_us}, "b", &second}};
  const auto report = buildScene(base, {.output = folder / "two.fls", .epochs = epochs});
  ASSERT_TRUE(report.ok()) << report.error().message;
  const auto two = *Scene::open(folder / "two.fls"), one = test::makeScene(200, 200, uint64_t{4});
  uint64_t differ = 0, nodes = 0;
  for (proto::Slot slot = 0; slot < one->grid().slotCount(); ++slot) {
    const NodeId n = one->grid().node(slot);
    if (n == NodeId{}) continue;
    const uint32_t s = 3u << one->grid().scaleLog2(n);  // how far the supports of a node and its descendants reach
    const bool is_near =
        n.x() + s >= w.x && n.x() <= w.x + w.width + s && n.y() + s >= w.y && n.y() <= w.y + w.height + s;
    if (is_near) continue;
    ++nodes;
    differ += two->nodes()[slot].error() != one->nodes()[slot].error() ? 1 : 0;
  }
  EXPECT_GT(nodes, 30'000u);
  EXPECT_EQ(differ, 0u);
  ASSERT_EQ(report->epochs.size(), 2u);
  EXPECT_GT(report->epochs[1].changed_samples, 100u);
  EXPECT_LE(report->epochs[1].changed_samples, 12u * 9);
}

// What an epoch does not change is stored once.
TEST(Epochs, ShareWhatIsEqual) {
  test::FormulaSource base(200, 200, test::hills(4));
  const LatticeWindow large{0, 0, 150, 150}, small{20, 30, 12, 9};
  std::vector<test::FormulaSource> sources{test::windowSource(base, large, test::hills(4)),
                                           test::windowSource(base, large, test::hills(5)),
                                           test::windowSource(base, small, test::hills(6))};
  std::vector<EpochRequest> epochs;
  for (size_t i = 0; i < 3; ++i)
    epochs.push_back({Time{static_cast<int64_t>(i) * kDay_us}, std::to_string(i), &sources[i]});
  const test::TemporaryFolder folder;
  const auto report = buildScene(base, {.output = folder / "a.fls", .epochs = epochs});
  ASSERT_TRUE(report.ok()) << report.error().message;
  EXPECT_GT(report->epochs[1].bytes, 150u * 150 * 4);
  EXPECT_LT(report->epochs[2].bytes, report->epochs[1].bytes / 4);
}

TEST(Epochs, OnAnotherGridAreRefusedByName) {
  test::FormulaSource base(50, 40, test::hills(1));
  const auto refusal = [&](const std::function<void(ElevationInfo&)>& spoil, LatticeWindow w = {5, 5, 10, 10}) {
    test::FormulaSource first = test::windowSource(base, {0, 0, 50, 40}, test::hills(1)),
                        second = test::windowSource(base, w, test::hills(2));
    second.info().title = "second.tif";
    spoil(second.info());
    const test::TemporaryFolder folder;
    const auto report =
        buildScene(base, {.output = folder / "a.fls",
                          .epochs = {{Time{0}, "2001-01-01", &first}, {Time{kDay_us}, "2001-01-02", &second}}});
    EXPECT_FALSE(std::filesystem::exists(folder / "a.fls"));
    return report.ok() ? std::string("built") : report.error().message;
  };
  const auto expect = [](const std::string& message, const std::string& why) {
    EXPECT_NE(message.find("2001-01-02"), std::string::npos) << message;
    EXPECT_NE(message.find("second.tif"), std::string::npos) << message;
    EXPECT_NE(message.find(why), std::string::npos) << message;
  };
  expect(refusal([](ElevationInfo& info) { info.frame.axis_x_m.x = 9; }), "spaced otherwise");
  expect(refusal([](ElevationInfo& info) { info.frame.map_origin_m.x += 4; }), "lie between");
  expect(refusal([](ElevationInfo& info) { info.frame.map_origin_m.y += 300; }), "reaches beyond");
  expect(refusal([](ElevationInfo& info) { info.frame.map_origin_m.y -= 100; }), "reaches beyond");
  base.info().crs_wkt = "here";
  expect(refusal([](ElevationInfo& info) { info.crs_wkt = "there"; }), "reference system");
}

TEST(Epochs, OutOfOrderAreRefusedByDate) {
  test::FormulaSource base(20, 20, test::hills(1)), same = test::windowSource(base, {0, 0, 20, 20}, test::hills(1));
  const test::TemporaryFolder folder;
  const auto message = [&](Time a, Time b) {
    const auto report =
        buildScene(base, {.output = folder / "a.fls", .epochs = {{a, "first", &same}, {b, "second", &same}}});
    return report.ok() ? std::string("built") : report.error().message;
  };
  EXPECT_NE(message(Time{5}, Time{5}).find("two epochs are of second"), std::string::npos);
  EXPECT_NE(message(Time{5}, Time{4}).find("second comes after that of first"), std::string::npos);
  EXPECT_EQ(message(Time{4}, Time{5}), "built");
}

}  // namespace
}  // namespace foreland::terrain
