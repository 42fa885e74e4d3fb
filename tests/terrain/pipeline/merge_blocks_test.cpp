#include "terrain/pipeline/merge_blocks.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numeric>
#include <optional>
#include <tuple>
#include <vector>

#include "terrain/pipeline/block_file.h"
#include "terrain/pipeline/build.h"
#include "terrain/pipeline/build_by_blocks.h"
#include "terrain/pipeline/void_fill.h"
#include "terrain/store/verify.h"
#include "tests/support/files.h"
#include "tests/support/formula_picture.h"
#include "tests/support/scene.h"
#include "tests/support/seed.h"
#include "tests/support/surface_file.h"

namespace foreland::terrain {
namespace {

using proto::FrameKind;

test::FormulaSource sourceOf(uint32_t width, uint32_t height, FrameKind kind, uint64_t seed = 1) {
  test::FormulaSource source(width, height, test::hills(seed), kind);
  // Not a sum of powers of two: positions are rounded.
  source.info().frame.anchor += glm::dvec2(0.1, 0.7);
  source.info().notes = {"a note"};
  return source;
}

// A source with voids of a kind: specks, a lake, a part of the border, a large part, rows, and all of these.
test::FormulaSource sourceWithVoids(uint32_t width, uint32_t height, FrameKind kind, uint64_t voids, uint64_t seed,
                                    double step_m = 0) {
  const auto isVoid = [=](uint32_t x, uint32_t y) {
    const auto has = [&](uint64_t of) { return voids == of || voids == 5; };
    return (has(0) && Rng(seed ^ (uint64_t{y} << 32 | x)).below(40) == 0) ||
           (has(1) && std::hypot(x - 0.6 * width, y - 0.4 * height) < 0.05 * width + 9 * std::sin(0.2 * x)) ||
           (has(2) && x + 3.0 * std::cos(0.05 * y) < 20) ||
           (has(3) && y > 0.7 * height + 40 * std::sin(0.01 * x) && x % 97 != 0) || (has(4) && y % 256 < 2);
  };
  test::FormulaSource source = sourceOf(width, height, kind, seed);
  const auto ground = test::hills(seed);
  test::FormulaSource holed(
      width, height,
      [=](uint32_t x, uint32_t y) {
        const double h = ground(x, y);
        return isVoid(x, y) ? std::nan("") : step_m > 0 ? step_m * std::round(h / step_m) : h;
      },
      kind);
  holed.info() = source.info();
  holed.info().voids_filled = 3;  // by the source
  return holed;
}

struct Sharded {
  test::TemporaryFolder voids;
  BlockPlan plan;
  proto::GridTopology grid;
  Blocks blocks;
  proto::GeographicTables tables;
  std::vector<EpochRequest> epochs;
  Sharded(ElevationSource& source, uint32_t block_log2, std::vector<EpochRequest> requests = {},
          proto::EpochBlend blend = proto::EpochBlend::kLinear)
      : plan(planBlocks(source,
                        {.block_log2 = block_log2, .epochs = requests, .epoch_blend = blend, .voids = voids / "plan."})
                 .value()),
        grid(proto::GridTopology::create(plan.shape).value()),
        blocks{grid, block_log2},
        tables(proto::FrameTransform(plan.frame), grid.maxX(), grid.maxY()),
        epochs(std::move(requests)) {}

  Status make(ElevationSource& input, const std::filesystem::path& folder, uint64_t number) const {
    const GroundInTime ground(input, epochs, plan.voids);
    const auto column = static_cast<uint32_t>(number % blocks.columns()),
               row = static_cast<uint32_t>(number / blocks.columns());
    const auto heights = readWindow(ground, blocks.withHalo(column, row));
    if (!heights) return heights.error();
    return writeBlock(folder, plan, input.info(), blocks, tables, column, row, plan.ids[number], *heights);
  }
};

// The law: whatever the size of blocks, their order and the threads, the file is the one that is made at once.
TEST(MergeBlocks, GivesTheBytesThatABuildAtOnceGives) {
  Rng rng(test::randomSeed());
  for (const auto& [width, height, kind] : {std::tuple{1100u, 700u, FrameKind::kPlanar},
                                            {1025u, 1025u, FrameKind::kGeographic},
                                            {530u, 2000u, FrameKind::kPlanar},
                                            {1500u, 513u, FrameKind::kGeographic}}) {
    const test::TemporaryFolder folder;
    test::FormulaSource source = sourceOf(width, height, kind, rng.next());
    ASSERT_TRUE(buildScene(source, {.output = folder / "whole.fls"}).ok());
    const std::vector<char> whole = test::slurp(folder / "whole.fls");
    for (const uint32_t log2 : {9u, 10u, 11u}) {
      const Sharded sharded(source, log2);
      std::vector<uint64_t> order(sharded.blocks.count());
      std::iota(order.begin(), order.end(), 0);
      for (size_t i = order.size(); i > 1; --i) std::swap(order[i - 1], order[rng.below(i)]);
      for (const uint64_t number : order) ASSERT_TRUE(sharded.make(source, folder.path(), number).ok());
      const auto merged = mergeBlocks(source, sharded.plan, {folder.path(), folder / "merged.fls", log2 - 8});
      ASSERT_TRUE(merged.ok()) << merged.error().message;
      EXPECT_TRUE(test::slurp(folder / "merged.fls") == whole) << width << " x " << height << " by 2^" << log2;
    }
  }
}

TEST(MergeBlocks, FillVoidsAsABuildAtOnceDoes) {
  Rng rng(test::randomSeed());
  for (uint64_t voids = 0; voids < 6; ++voids) {
    const test::TemporaryFolder folder;
    const FrameKind kind = voids % 2 ? FrameKind::kGeographic : FrameKind::kPlanar;
    test::FormulaSource source = sourceWithVoids(static_cast<uint32_t>(530 + rng.below(200)),
                                                 static_cast<uint32_t>(530 + rng.below(200)), kind, voids, rng.next());
    ASSERT_TRUE(buildScene(source, {.output = folder / "whole.fls"}).ok());
    const Sharded sharded(source, 9);
    ASSERT_NE(sharded.plan.voids, nullptr);
    for (uint64_t i = sharded.blocks.count(); i > 0; --i) ASSERT_TRUE(sharded.make(source, folder.path(), i - 1).ok());
    const auto merged = mergeBlocks(source, sharded.plan, {folder.path(), folder / "merged.fls"});
    ASSERT_TRUE(merged.ok()) << merged.error().message;
    EXPECT_TRUE(test::slurp(folder / "merged.fls") == test::slurp(folder / "whole.fls")) << "voids of kind " << voids;
  }
}

// The quantum is one for the heights that there are, whatever voids are filled with; it and voids are noted.
TEST(MergeBlocks, FilledVoidsDoNotNarrowTheQuantum) {
  const test::TemporaryFolder folder;
  test::FormulaSource source = sourceWithVoids(700, 900, FrameKind::kPlanar, 5, 3, 0.5);
  const auto whole = buildScene(source, {.output = folder / "whole.fls", .widen_quantum = true});
  ASSERT_TRUE(whole.ok());
  EXPECT_EQ(whole->height_quantum_m, 0.5);
  const auto built =
      buildByBlocks(source, {.plan = {.widen_quantum = true, .block_log2 = 9}, .output = folder / "a.fls"});
  ASSERT_TRUE(built.ok()) << built.error().message;
  EXPECT_EQ(built->notes, whole->notes);
  EXPECT_EQ(built->voids_filled, whole->voids_filled);
  EXPECT_TRUE(test::slurp(folder / "a.fls") == test::slurp(folder / "whole.fls"));
  EXPECT_FALSE(std::filesystem::exists(folder / "a.fls.blocks"));
}

// Ground that changes in windows of its own at each date: in blocks, across them, over all of it, or not at all.
struct Story {
  std::vector<test::FormulaSource> sources;
  std::vector<EpochRequest> epochs;

  Story(const test::FormulaSource& whole, size_t count, Rng& rng) {
    const ElevationInfo& info = whole.info();
    for (size_t i = 0; i < count; ++i) {
      const auto place = [&](uint32_t samples) {
        const auto from = static_cast<uint32_t>(rng.below(samples - 1));
        return std::pair(from, static_cast<uint32_t>(1 + rng.below(samples - from)));
      };
      auto [x, width] = place(info.width);
      auto [y, height] = place(info.height);
      if (rng.below(4) == 0) x = 0, y = 0, width = info.width, height = info.height;
      const uint64_t seed = rng.next();
      const double metres = rng.uniform(-200, 200), rough = rng.below(2) ? 9 : 0;
      sources.push_back(
          test::windowSource(whole, {x, y, width, height}, [=, ground = test::hills(1)](uint32_t at_x, uint32_t at_y) {
            Rng any(seed ^ at_x << 20 ^ at_y);
            const double bump =
                metres * std::exp(-0.0005 * (std::pow(at_x - x - 40.0, 2) + std::pow(at_y - y - 50.0, 2)));
            return any.below(17) == 0 ? std::nan("") : ground(at_x, at_y) + bump + any.uniform(-rough, rough);
          }));
    }
    Time date = Time::seconds(-1000);
    for (size_t i = 0; i < count; ++i) {
      epochs.push_back({date, "date " + std::to_string(i), &sources[i]});
      date = date + Duration{static_cast<int64_t>(1 + rng.below(400)) * 86'400'000'000};
    }
    // A date at which everything is as before.
    if (rng.below(2)) epochs.push_back({date, "nothing", nullptr});
  }
};

std::string describe(const std::vector<EpochReport>& epochs) {
  std::string text;
  for (const EpochReport& e : epochs)
    text += e.date + " " + std::to_string(e.changed_samples) + " " + std::to_string(e.max_m) + " " +
            std::to_string(e.bytes) + "\n";
  return text;
}

// The law of ground that changes in time.
TEST(MergeBlocks, GiveTheBytesOfGroundInTimeThatABuildAtOnceGives) {
  const uint64_t seed = test::randomSeed();
  SCOPED_TRACE(seed);
  Rng rng(seed);
  for (const auto& [width, height, kind, log2, blend, has_voids] :
       {std::tuple{1100u, 700u, FrameKind::kPlanar, 9u, proto::EpochBlend::kLinear, false},
        {1025u, 530u, FrameKind::kGeographic, 9u, proto::EpochBlend::kBSpline, false},
        {530u, 1025u, FrameKind::kPlanar, 10u, proto::EpochBlend::kBSpline, true},
        {600u, 1100u, FrameKind::kGeographic, 9u, proto::EpochBlend::kLinear, true}}) {
    const test::TemporaryFolder folder;
    test::FormulaSource source =
        has_voids ? sourceWithVoids(width, height, kind, 5, 3) : sourceOf(width, height, kind, rng.next());
    const Story story(source, 2 + rng.below(4), rng);
    const auto whole =
        buildScene(source, {.output = folder / "whole.fls", .epochs = story.epochs, .epoch_blend = blend});
    ASSERT_TRUE(whole.ok()) << whole.error().message;
    const Sharded sharded(source, log2, story.epochs, blend);
    std::vector<uint64_t> order(sharded.blocks.count());
    std::iota(order.begin(), order.end(), 0);
    for (size_t i = order.size(); i > 1; --i) std::swap(order[i - 1], order[rng.below(i)]);
    for (const uint64_t number : order) {
      const Status made = sharded.make(source, folder.path(), number);
      ASSERT_TRUE(made.ok()) << made.error().message;
    }
    const auto merged = mergeBlocks(source, sharded.plan, {folder.path(), folder / "merged.fls"});
    ASSERT_TRUE(merged.ok()) << merged.error().message;
    EXPECT_TRUE(test::slurp(folder / "merged.fls") == test::slurp(folder / "whole.fls"))
        << width << " x " << height << " by 2^" << log2;
    EXPECT_EQ(describe(merged->epochs), describe(whole->epochs));
    EXPECT_EQ(merged->lowest_m, whole->lowest_m);
    EXPECT_EQ(merged->highest_m, whole->highest_m);
    EXPECT_TRUE(verifyScene(folder / "merged.fls")->sound());
  }
}

// An epoch's file that changes renames the blocks whose halos hold the change; a date that says nothing of a block does
// not, and a block of which none says anything is that of a scene that does not change.
TEST(MergeBlocks, AChangeOfAnEpochIsThatOfItsBlocksAlone) {
  test::FormulaSource source = sourceOf(2000, 2000, FrameKind::kPlanar);
  const auto epochOf = [&](double more, proto::LatticeWindow w) {
    return test::windowSource(source, w, [=, ground = test::hills(1)](uint32_t x, uint32_t y) {
      return x % 400 < 300 && y > 600 ? ground(x, y) + 5 + (x == 1030 && y == 700 ? more : 0) : std::nan("");
    });
  };
  test::FormulaSource one = epochOf(0, {0, 500, 1200, 300}), same = epochOf(0, {4, 560, 1196, 220}),
                      other = epochOf(1, {0, 500, 1200, 300}), late = epochOf(0, {1600, 1700, 100, 100});
  const auto idsOf = [&](std::vector<EpochRequest> epochs) { return Sharded(source, 9, std::move(epochs)).plan.ids; };
  const auto differ = [](const std::vector<uint64_t>& a, const std::vector<uint64_t>& b) {
    std::vector<size_t> numbers;
    for (size_t i = 0; i < a.size(); ++i)
      if (a[i] != b[i]) numbers.push_back(i);
    return numbers;
  };
  const EpochRequest first{Time{0}, "first", nullptr};
  const auto still = idsOf({}), before = idsOf({first, {Time{9}, "then", &one}});
  EXPECT_EQ(differ(still, before), (std::vector<size_t>{4, 5, 6}));
  EXPECT_EQ(differ(before, idsOf({first, {Time{9}, "then", &other}})), (std::vector<size_t>{5, 6}));
  EXPECT_EQ(differ(before, idsOf({first, {Time{9}, "then", &same}})), (std::vector<size_t>{4, 5, 6}));
  EXPECT_EQ(differ(before, idsOf({first, {Time{9}, "then", &one}, {Time{12}, "late", &late}})),
            (std::vector<size_t>{15}));
  EXPECT_EQ(differ(before, idsOf({first, {Time{10}, "then", &one}})), (std::vector<size_t>{4, 5, 6}));
  const auto plan = [&](Time date) { return Sharded(source, 9, {first, {date, "then", nullptr}}).plan; };
  EXPECT_EQ(plan(Time{9}).ids, still);
  EXPECT_NE(plan(Time{9}).id(), plan(Time{10}).id());
}

TEST(MergeBlocks, NameAnEpochThatCannotBe) {
  const test::TemporaryFolder folder;
  test::FormulaSource source = sourceOf(1100, 700, FrameKind::kPlanar);
  test::FormulaSource off = test::windowSource(source, {5, 5, 10, 10}, test::hills(2)),
                      tall(10, 10, [](uint32_t, uint32_t) { return 3e38; });
  tall.info().frame = off.info().frame;
  off.info().title = "off.tif";
  off.info().frame.map_origin_m.x += 4;
  const auto refusal = [&](ElevationSource* epoch, Time date, proto::EpochBlend blend = proto::EpochBlend::kLinear) {
    const std::vector<EpochRequest> epochs{{Time{0}, "first", nullptr}, {date, "second", epoch}};
    const auto by_blocks = buildByBlocks(
        source, {.plan = {.block_log2 = 9, .epochs = epochs, .epoch_blend = blend}, .output = folder / "a.fls"});
    EXPECT_FALSE(by_blocks.ok());
    EXPECT_TRUE(std::filesystem::is_empty(folder.path()));
    if (blend == proto::EpochBlend::kLinear) {
      EXPECT_EQ(buildScene(source, {.output = folder / "a.fls", .epochs = epochs}).error().message,
                by_blocks.error().message);
    }
    return by_blocks.error().message;
  };
  EXPECT_NE(refusal(&off, Time{5}).find("epoch second: off.tif"), std::string::npos);
  EXPECT_NE(refusal(&tall, Time{5}).find("epoch second: a height of"), std::string::npos);
  EXPECT_NE(refusal(nullptr, Time{0}).find("two epochs are of second"), std::string::npos);
  EXPECT_NE(refusal(nullptr, Time{5}, proto::EpochBlend::kCatmullRom).find("catmull-rom"), std::string::npos);
}

// At lattice positions, as `foreland build` takes objects.
std::vector<ObjectRequest> objectsAt(const std::string& model, const proto::Frame& frame,
                                     const std::vector<glm::dvec2>& places) {
  const proto::FrameTransform transform(frame);
  std::vector<ObjectRequest> requests;
  for (const glm::dvec2& place : places) {
    const auto point = transform.toScene(proto::LatticePosition{place.x, place.y, 0});
    glm::dvec2 at = frame.map_origin_m + glm::dvec2(point);
    if (frame.kind == FrameKind::kGeographic) {
      const proto::Geodetic g = transform.toGeodetic(point);
      at = glm::dvec2(g.latitude_rad, g.longitude_rad) * 57.29577951308232;
    }
    requests.push_back({model, at, 1, 30, 2});
  }
  return requests;
}

Rgba stripes(double x, double y) {
  const auto wave = [](double phase) { return static_cast<uint8_t>(std::lround(128 + 80 * std::sin(phase))); };
  return {wave(x * 0.9), wave(y * 0.11), wave((x + y) * 0.05), static_cast<uint8_t>(x > 500 ? 0 : 255)};
}

// What a scene has beside its ground, and of which texels its picture is, 0 for none.
struct Dressed {
  uint32_t width, height;
  FrameKind kind;
  PageCoding coding;
  bool has_objects;
  double texel;
  uint32_t block_log2;
  unsigned threads;
  bool has_voids = false;
  bool changes_in_time = false;
};

// The law again, with all that a scene has beside its ground, one by one and together.
TEST(MergeBlocks, TakesWhatABuildAtOnceTakes) {
  constexpr auto kPlanar = FrameKind::kPlanar, kGeographic = FrameKind::kGeographic;
  const test::TemporaryFolder folder;
  const std::string model = folder / "sphere.fls";
  test::writeSphere(model);
  for (const Dressed& d : {Dressed{700, 540, kPlanar, PageCoding::kCoded, false, 0, 9, 1},
                           {1025, 530, kGeographic, PageCoding::kPlain, true, 0, 9, 3},
                           {700, 530, kPlanar, PageCoding::kPlain, false, 0.5, 9, 3},
                           {530, 700, kGeographic, PageCoding::kCoded, true, 1, 9, 2},
                           {1100, 530, kPlanar, PageCoding::kCoded, true, 4, 10, 2},
                           {700, 700, kGeographic, PageCoding::kPlain, false, 8, 9, 1},
                           {700, 540, kPlanar, PageCoding::kCoded, true, 2, 9, 2, true},
                           {700, 600, kPlanar, PageCoding::kCoded, true, 2, 9, 2, true, true},
                           {530, 700, kGeographic, PageCoding::kPlain, true, 1, 9, 3, false, true}}) {
    test::FormulaSource source =
        d.has_voids ? sourceWithVoids(d.width, d.height, d.kind, 5, 3) : sourceOf(d.width, d.height, d.kind);
    test::FormulaPicture picture(d.width, d.height, d.texel > 0 ? d.texel : 1, stripes);
    SceneAdditions additions{.page_coding = d.coding};
    if (d.has_objects)
      additions.objects =
          objectsAt(model, source.info().frame, {{511.5, 511.25}, {512, 3.75}, {d.width - 1.001, d.height - 1.001}});
    if (d.texel > 0) additions.picture = &picture, additions.imagery_quality = 60, additions.attribution = "me";
    Rng rng(7);
    const Story story(source, d.changes_in_time ? 3 : 0, rng);
    const std::vector<EpochRequest> epochs = d.changes_in_time ? story.epochs : std::vector<EpochRequest>();
    if (d.changes_in_time && d.has_objects) {
      test::writeGrowingSphere(folder / "growing.fls", epochs[0].time, epochs[2].time);
      additions.objects.push_back(objectsAt(folder / "growing.fls", source.info().frame, {{40, 500}}).front());
    }
    const auto whole =
        buildScene(source, {.output = folder / "whole.fls", .threads = 2, .epochs = epochs, .additions = additions});
    ASSERT_TRUE(whole.ok()) << whole.error().message;
    const auto built = buildByBlocks(source, {.plan = {.block_log2 = d.block_log2, .epochs = epochs},
                                              .output = folder / "blocks.fls",
                                              .threads = d.threads,
                                              .additions = additions});
    ASSERT_TRUE(built.ok()) << built.error().message;
    EXPECT_TRUE(test::slurp(folder / "blocks.fls") == test::slurp(folder / "whole.fls"))
        << d.width << " x " << d.height << ", texels of " << d.texel;
    EXPECT_EQ(built->scene_id, whole->scene_id);
    EXPECT_EQ(built->file_bytes, whole->file_bytes);
    EXPECT_EQ(built->notes, whole->notes);
    EXPECT_EQ(built->imagery.tiles, whole->imagery.tiles);
    EXPECT_EQ(built->imagery.stored, whole->imagery.stored);
  }
}

TEST(MergeBlocks, NamesAnObjectThatCannotStand) {
  const test::TemporaryFolder folder;
  test::FormulaSource source = sourceOf(1100, 700, FrameKind::kPlanar);
  const auto refusal = [&](const ObjectRequest& object) {
    const auto built = buildByBlocks(
        source, {.plan = {.block_log2 = 9}, .output = folder / "a.fls", .additions = {.objects = {object}}});
    EXPECT_FALSE(std::filesystem::exists(folder / "a.fls"));
    return built.ok() ? "" : built.error().message;
  };
  const std::string sphere = folder / "sphere.fls", growing = folder / "growing.fls";
  test::writeSphere(sphere);
  test::writeGrowingSphere(growing, Time::seconds(0), Time::seconds(1));
  EXPECT_NE(refusal({sphere, {1e7, 1e7}}).find("beyond the data"), std::string::npos);
  EXPECT_NE(refusal({growing, source.info().frame.map_origin_m}).find("--epoch"), std::string::npos);
}

TEST(MergeBlocks, WindowsOfAnySizeGiveTheSameBytesAndLeaveNothing) {
  const test::TemporaryFolder folder;
  test::FormulaSource source = sourceOf(1300, 1300, FrameKind::kPlanar);
  ASSERT_TRUE(buildScene(source, {.output = folder / "whole.fls", .widen_quantum = true}).ok());
  for (const uint64_t memory : {uint64_t{1}, uint64_t{1} << 24, uint64_t{1} << 30}) {
    const auto built = buildByBlocks(
        source, {.plan = {.widen_quantum = true, .memory_bytes = memory, .block_log2 = 9}, .output = folder / "a.fls"});
    ASSERT_TRUE(built.ok()) << built.error().message;
    EXPECT_TRUE(test::slurp(folder / "a.fls") == test::slurp(folder / "whole.fls"));
    EXPECT_FALSE(std::filesystem::exists(folder / "a.fls.blocks"));
  }
  EXPECT_TRUE(verifyScene(folder / "a.fls")->sound());
}

// A build that stops in the middle keeps its blocks, and the next one makes only those that are missing or damaged.
TEST(MergeBlocks, AStoppedBuildGoesOn) {
  const test::TemporaryFolder folder;
  test::FormulaSource source = sourceOf(1300, 1300, FrameKind::kPlanar);
  const WindowedOptions options{.plan = {.block_log2 = 9}, .output = folder / "a.fls"};
  int asked = 0;
  ASSERT_FALSE(buildByBlocks(source, options, {.keepGoing = [&] { return ++asked < 6; }}).ok());
  std::vector<std::filesystem::path> kept;
  for (const auto& entry : std::filesystem::directory_iterator(folder / "a.fls.blocks")) kept.push_back(entry.path());
  ASSERT_GE(kept.size(), 2u);
  const auto before = std::filesystem::last_write_time(kept.front());
  std::filesystem::resize_file(kept.back(), 100);
  bool is_kept = false;
  const auto built = buildByBlocks(source, options, {.report = [&](std::string_view stage, double) {
                                     if (stage == "merging")
                                       is_kept = std::filesystem::last_write_time(kept.front()) == before;
                                   }});
  ASSERT_TRUE(built.ok()) << built.error().message;
  EXPECT_TRUE(is_kept);
  ASSERT_TRUE(buildScene(source, {.output = folder / "whole.fls"}).ok());
  EXPECT_TRUE(test::slurp(folder / "a.fls") == test::slurp(folder / "whole.fls"));
}

// A build that stops when its voids are filled does not fill them again, unless what is kept of it is damaged.
TEST(MergeBlocks, AStoppedBuildKeepsWhatVoidsAreFilledWith) {
  const test::TemporaryFolder folder;
  test::FormulaSource source = sourceWithVoids(700, 900, FrameKind::kPlanar, 5, 4);
  ASSERT_TRUE(buildScene(source, {.output = folder / "whole.fls"}).ok());
  for (const bool is_damaged : {false, true}) {
    const WindowedOptions options{.plan = {.block_log2 = 9}, .output = folder / "a.fls"};
    bool is_filled = false;
    ASSERT_FALSE(buildByBlocks(source, options,
                               {.report = [&](std::string_view stage, double) { is_filled |= stage == "bounding"; },
                                .keepGoing = [&] { return !is_filled; }})
                     .ok());
    std::filesystem::path fill;
    for (const auto& entry : std::filesystem::directory_iterator(folder / "a.fls.blocks"))
      if (entry.path().extension() == ".voids") fill = entry.path();
    ASSERT_FALSE(fill.empty());
    if (is_damaged) {
      std::vector<char> bytes = test::slurp(fill);
      bytes[bytes.size() / 2] ^= 1;
      test::spit(fill, bytes);
    }
    const auto before = std::filesystem::last_write_time(fill);
    bool is_kept = false;
    const auto built = buildByBlocks(source, options, {.report = [&](std::string_view stage, double) {
                                       if (stage == "merging")
                                         is_kept = std::filesystem::last_write_time(fill) == before;
                                     }});
    ASSERT_TRUE(built.ok()) << built.error().message;
    EXPECT_NE(is_kept, is_damaged);
    EXPECT_TRUE(test::slurp(folder / "a.fls") == test::slurp(folder / "whole.fls"));
  }
}

// One sample that changes, changes the ids of the blocks whose halos hold it, and no others.
TEST(MergeBlocks, AChangeIsThatOfItsBlocksAlone) {
  test::FormulaSource source = sourceOf(2000, 2000, FrameKind::kPlanar);
  const auto hills = test::hills(1);
  test::FormulaSource changed(2000, 2000,
                              [&](uint32_t x, uint32_t y) { return hills(x, y) + (x == 1030 && y == 700 ? 1 : 0); });
  changed.info().frame = source.info().frame;
  const Sharded before(source, 9), after(changed, 9);
  std::vector<size_t> differ;
  for (size_t i = 0; i < before.plan.ids.size(); ++i)
    if (before.plan.ids[i] != after.plan.ids[i]) differ.push_back(i);
  EXPECT_EQ(differ, (std::vector<size_t>{before.blocks.columns() + 1, before.blocks.columns() + 2}));
}

TEST(MergeBlocks, NamesTheBlockThatIsMissingDamagedOrAnother) {
  const test::TemporaryFolder folder;
  test::FormulaSource source = sourceOf(1100, 700, FrameKind::kPlanar);
  const Sharded sharded(source, 9);
  for (uint64_t number = 0; number < sharded.blocks.count(); ++number)
    ASSERT_TRUE(sharded.make(source, folder.path(), number).ok());
  const auto refusal = [&] {
    const auto merged = mergeBlocks(source, sharded.plan, {folder.path(), folder / "a.fls"});
    EXPECT_FALSE(std::filesystem::exists(folder / "a.fls"));
    return merged.ok() ? "" : merged.error().message;
  };
  const auto path = blockPath(folder.path(), sharded.plan.ids[3]);
  const std::vector<char> sound = test::slurp(path);
  std::vector<char> damaged = sound;
  damaged[damaged.size() / 2] ^= 1;
  test::spit(path, damaged);
  EXPECT_NE(refusal().find(path.string() + ": damaged"), std::string::npos);
  test::spit(path, {sound.begin(), sound.begin() + 200});
  EXPECT_NE(refusal().find(path.string() + ": damaged"), std::string::npos);
  test::spit(path, test::slurp(blockPath(folder.path(), sharded.plan.ids[2])));
  EXPECT_NE(refusal().find("another block"), std::string::npos);
  std::filesystem::remove(path);
  EXPECT_NE(refusal().find("block 3 of the plan is missing"), std::string::npos);
}

TEST(MergeBlocks, NamesTheBlockWhoseLayersAreDamaged) {
  const test::TemporaryFolder folder;
  test::FormulaSource source = sourceOf(1100, 700, FrameKind::kPlanar),
                      later = test::windowSource(source, {500, 100, 40, 30}, test::hills(2));
  const Sharded sharded(source, 9, {{Time{0}, "first", nullptr}, {Time{1}, "later", &later}});
  for (uint64_t number = 0; number < sharded.blocks.count(); ++number)
    ASSERT_TRUE(sharded.make(source, folder.path(), number).ok());
  const auto path = blockPath(folder.path(), sharded.plan.ids[0]);
  const std::vector<char> sound = test::slurp(path);
  const size_t before_layers = sound.size() - 3 * (40 + 13 * 30 * sizeof(int32_t));  // its last 13 columns, thrice
  const auto refusal = [&](const std::vector<char>& bytes) {
    test::spit(path, bytes);
    const auto merged = mergeBlocks(source, sharded.plan, {folder.path(), folder / "a.fls"});
    EXPECT_EQ(std::filesystem::exists(folder / "a.fls"), merged.ok());
    return merged.ok() ? "" : merged.error().message;
  };
  for (const size_t at :
       {before_layers, before_layers + 8, before_layers + 24, before_layers + 3 * 40 + 5, sound.size() - 1}) {
    std::vector<char> damaged = sound;
    damaged[at] ^= 1;
    EXPECT_NE(refusal(damaged).find(path.string() + ": damaged"), std::string::npos) << at;
  }
  EXPECT_NE(refusal({sound.begin(), sound.end() - 4}).find(path.string() + ": damaged"), std::string::npos);
  EXPECT_EQ(refusal(sound), "");
}

TEST(MergeBlocks, RefusesWhatBlocksCannotMake) {
  test::FormulaSource small(40, 40, test::hills(1));
  EXPECT_NE(planBlocks(small, {}).error().message.find("at once"), std::string::npos);
  const test::TemporaryFolder folder;
  test::FormulaSource voids(1000, 1000, [](uint32_t, uint32_t) { return std::nan(""); });
  const auto by_blocks = buildByBlocks(voids, {.plan = {}, .output = folder / "a.fls"});
  EXPECT_EQ(by_blocks.error().message, buildScene(voids, {.output = folder / "a.fls"}).error().message);
  EXPECT_TRUE(std::filesystem::is_empty(folder.path()));
  test::FormulaSource tall(1000, 1000, [](uint32_t x, uint32_t) { return x == 4 ? 3e38 : 0.0; });
  EXPECT_EQ(planBlocks(tall, {}).error().code, ErrorCode::kLimit);
}

}  // namespace
}  // namespace foreland::terrain
