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
  Sharded(ElevationSource& source, uint32_t block_log2)
      : plan(planBlocks(source, {.block_log2 = block_log2, .voids = voids / "plan."}).value()),
        grid(proto::GridTopology::create(plan.shape).value()),
        blocks{grid, block_log2},
        tables(proto::FrameTransform(plan.frame), grid.maxX(), grid.maxY()) {}

  Status make(ElevationSource& input, const std::filesystem::path& folder, uint64_t number) const {
    std::optional<FilledSource> filled;
    if (plan.voids) filled.emplace(input, *plan.voids);
    ElevationSource& source = filled ? *filled : input;
    const auto column = static_cast<uint32_t>(number % blocks.columns()),
               row = static_cast<uint32_t>(number / blocks.columns());
    const auto heights = readWindow(source, blocks.withHalo(column, row));
    if (!heights) return heights.error();
    return writeBlock(folder, plan, source.info(), blocks, tables, column, row, plan.ids[number], *heights);
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
                           {700, 540, kPlanar, PageCoding::kCoded, true, 2, 9, 2, true}}) {
    test::FormulaSource source =
        d.has_voids ? sourceWithVoids(d.width, d.height, d.kind, 5, 3) : sourceOf(d.width, d.height, d.kind);
    test::FormulaPicture picture(d.width, d.height, d.texel > 0 ? d.texel : 1, stripes);
    SceneAdditions additions{.page_coding = d.coding};
    if (d.has_objects)
      additions.objects =
          objectsAt(model, source.info().frame, {{511.5, 511.25}, {512, 3.75}, {d.width - 1.001, d.height - 1.001}});
    if (d.texel > 0) additions.picture = &picture, additions.imagery_quality = 60, additions.attribution = "me";
    const auto whole = buildScene(source, {.output = folder / "whole.fls",
                                           .threads = 2,
                                           .page_coding = d.coding,
                                           .objects = additions.objects,
                                           .picture = additions.picture,
                                           .imagery_quality = additions.imagery_quality,
                                           .attribution = additions.attribution});
    ASSERT_TRUE(whole.ok()) << whole.error().message;
    const auto built = buildByBlocks(source, {.plan = {.block_log2 = d.block_log2},
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
  EXPECT_NE(refusal({growing, source.info().frame.map_origin_m}).find("foreland build"), std::string::npos);
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
