// Scenes with deep pages here and there: where all pages are there they are those of the builder of whole scenes; their
// bounds hold, by a reference that knows no trees; and what is not there costs nothing.
#include "terrain/pipeline/sparse_build.h"

#include <gtest/gtest.h>

#include "terrain/store/scene_writer.h"
#include "terrain/store/verify.h"
#include "tests/support/forged_scene.h"
#include "tests/support/seed.h"
#include "tests/support/sparse_scene.h"

namespace foreland::terrain {
namespace {

using proto::FrameKind;
using proto::GridTopology;
using proto::NodeId;
using proto::NodeRecord;
using proto::Slot;

constexpr uint32_t kWidth = 150, kHeight = 131;

struct Ground {
  Ground(FrameKind kind, uint64_t seed, uint32_t whole_log2, uint32_t width = kWidth, uint32_t height = kHeight)
      : grid(*sparseGrid(width, height, whole_log2)),
        frame(test::makeFrame(kind, width, height)),
        whole(test::makeScene(width, height, seed, kind)) {
    frame.height_quantum_m = 0.1;
  }

  int32_t height(NodeId v) const { return whole->height(v); }
  std::shared_ptr<const Scene> build(std::vector<Slot> pages, unsigned threads = 2) const {
    const auto report =
        buildSparseScene({grid, frame, std::move(pages), [&](NodeId v) { return height(v); }}, {path, threads});
    EXPECT_TRUE(report.ok()) << report.error().message;
    const auto scene = Scene::open(path);
    EXPECT_TRUE(scene.ok()) << scene.error().message;
    return *scene;
  }
  std::vector<Slot> all() const {
    return pagesWhere(grid, [](uint32_t, const proto::LatticeWindow&) { return true; });
  }
  // Those of a disc that shrinks from level to level, and a few others.
  std::vector<Slot> some(Rng& rng) const {
    const test::Disc disc{rng.uniform(0, kWidth), rng.uniform(0, kHeight), rng.uniform(0, 60)};
    std::vector<Slot> pages =
        pagesWhere(grid, [&](uint32_t, const proto::LatticeWindow& tile) { return disc.meets(tile); });
    for (int i = 0; i < 2; ++i) pages.push_back(rng.below(grid.slotCount()));
    return pages;
  }

  const test::TemporaryFolder folder;
  const std::filesystem::path path = folder / "sparse.fls";
  GridTopology grid;
  proto::Frame frame;
  std::shared_ptr<const Scene> whole;
};

class SparseBuild : public testing::TestWithParam<FrameKind> {};

void expectTheWholeScene(const Ground& ground, uint64_t seed) {
  const auto scene = ground.build(ground.all());
  EXPECT_EQ(scene->records().size(), ground.grid.slotCount());
  EXPECT_TRUE(verifyScene(ground.path, 2)->sound());
  for (Slot slot = 0; slot < ground.grid.slotCount(); ++slot) {
    const NodeRecord a = scene->nodes()[slot], b = ground.whole->nodes()[slot];
    ASSERT_EQ(a.height(), b.height()) << "seed " << seed << ", slot " << slot;
    ASSERT_EQ(a.displacement(), b.displacement()) << "seed " << seed << ", slot " << slot;
    ASSERT_EQ(a.error(), b.error()) << "seed " << seed << ", slot " << slot;
    ASSERT_EQ(a.radius(), b.radius()) << "seed " << seed << ", slot " << slot;
  }
}

TEST_P(SparseBuild, WithAllPagesIsTheWholeScene) {
  const uint64_t seed = test::randomSeed();
  expectTheWholeScene(Ground(GetParam(), seed, 3), seed);
}

// More levels than errors are measured down at a time.
TEST_P(SparseBuild, WithAllPagesOfManyLevelsIsTheWholeScene) {
  const uint64_t seed = test::randomSeed();
  const Ground ground(GetParam(), seed, 3, 590, 530);
  ASSERT_EQ(ground.grid.maxLevel(), 13);
  expectTheWholeScene(ground, seed);
}

// Whether a point lies in a closed triangle; of lattice points.
bool isInside(NodeId v, NodeId a, NodeId b, NodeId c) {
  const auto side = [&](NodeId p, NodeId q) {
    return (int64_t{q.x()} - p.x()) * (int64_t{v.y()} - p.y()) - (int64_t{q.y()} - p.y()) * (int64_t{v.x()} - p.x());
  };
  const int64_t s1 = side(a, b), s2 = side(b, c), s3 = side(c, a);
  return (s1 >= 0 && s2 >= 0 && s3 >= 0) || (s1 <= 0 && s2 <= 0 && s3 <= 0);
}

// The error of leaving a node out, planar: the largest difference at the scene's own heights of the data.
double plainError(const Scene& scene, NodeId n) {
  const GridTopology& grid = scene.grid();
  const auto doubleArea = [](NodeId p, NodeId q, NodeId r) {
    const auto x = [](NodeId v) { return static_cast<double>(v.x()); };
    const auto y = [](NodeId v) { return static_cast<double>(v.y()); };
    return (x(q) - x(p)) * (y(r) - y(p)) - (y(q) - y(p)) * (x(r) - x(p));
  };
  const auto [a, b] = grid.endpoints(n);
  double worst = 0;
  for (const NodeId apex : grid.apexes(n))
    for (uint32_t y = 0; y < kHeight; ++y)
      for (uint32_t x = 0; x < kWidth; ++x) {
        const NodeId v = NodeId::at(x, y);
        if (!isInside(v, a, b, apex)) continue;
        const double plane = (doubleArea(v, b, apex) * scene.height(a) + doubleArea(a, v, apex) * scene.height(b) +
                              doubleArea(a, b, v) * scene.height(apex)) /
                             doubleArea(a, b, apex);
        worst = std::max(worst, std::fabs(scene.height(v) - plane));
      }
  return worst;
}

TEST_P(SparseBuild, HasSoundBoundsThatHoldTheGroundThatIsThere) {
  const uint64_t seed = test::randomSeed();
  Rng rng(seed);
  for (int i = 0; i < 6; ++i) {
    const Ground ground(GetParam(), rng.next(), static_cast<uint32_t>(rng.below(5)) + 1);
    const auto scene = ground.build(ground.some(rng));
    const auto report = verifyScene(ground.path, 2);
    ASSERT_TRUE(report->sound()) << "seed " << seed << ": " << report->first_faults.front();
    EXPECT_LT(scene->records().size(), ground.grid.slotCount());
    for (int k = 0; k < 40; ++k) {
      const Slot slot = rng.below(ground.grid.slotCount());
      const NodeId n = ground.grid.node(slot);
      if (n == NodeId{} || !scene->pages().hasPage(slot)) continue;
      ASSERT_EQ(scene->height(n), ground.height(n));
      if (GetParam() != FrameKind::kPlanar || !ground.grid.touchesData(n)) continue;
      // Heights between nodes are rounded, which the bound is not.
      const double expected_m = 0.1 * (plainError(*scene, n) - 0.5);
      ASSERT_GE(scene->node(n).error().metres(), expected_m) << "seed " << seed << ", slot " << slot;
    }
  }
}

// Triangles that are not halved go on beyond the data, and so does what they hide of the ground before its border.
TEST(SparseBuildAtTheBorder, HasErrorsThatHoldWhatLiesAcross) {
  const Ground ground(FrameKind::kPlanar, 1, 4);
  const auto height = [](NodeId v) {
    return static_cast<int32_t>(v.x() >= kWidth || v.y() >= kHeight ? 40 * (v.x() % 37) : 0);
  };
  ASSERT_TRUE(buildSparseScene({ground.grid, ground.frame, {}, height}, {ground.path, 2}).ok());
  const auto scene = *Scene::open(ground.path);
  size_t across = 0;
  for (Slot slot = 0; slot < scene->pages().wholeSlots(); ++slot) {
    const NodeId n = ground.grid.node(slot);
    if (n == NodeId{} || !ground.grid.touchesData(n)) continue;
    const double expected_m = 0.1 * (plainError(*scene, n) - 0.5);
    ASSERT_GE(scene->node(n).error().metres(), expected_m) << "slot " << slot;
    across += expected_m > 0 ? 1 : 0;
  }
  EXPECT_GT(across, 5u);
}

// The ground where no page is lies in the middle of the edge that is not halved, if its ends are there.
TEST_P(SparseBuild, IsEvenWhereNoPageIs) {
  const uint64_t seed = test::randomSeed();
  Rng rng(seed);
  const Ground ground(GetParam(), seed, 5);
  const auto scene = ground.build(ground.some(rng));
  const auto isThere = [&](NodeId v) { return ground.grid.isBase(v) || scene->pages().hasPage(ground.grid.slot(v)); };
  size_t between = 0;
  for (uint32_t y = 0; y <= ground.grid.maxY(); ++y)
    for (uint32_t x = 0; x <= ground.grid.maxX(); ++x) {
      const NodeId v = NodeId::at(x, y);
      if (isThere(v)) continue;
      EXPECT_EQ(scene->node(v), NodeRecord{});
      const auto [a, b] = ground.grid.endpoints(v);
      const auto apexes = ground.grid.apexes(v);
      if (!isThere(a) || !isThere(b) || !std::all_of(apexes.begin(), apexes.end(), isThere)) continue;
      ++between;
      ASSERT_NEAR(scene->height(v), 0.5 * (scene->height(a) + scene->height(b)), 0.5) << "seed " << seed;
    }
  EXPECT_GT(between, 100u);
}

TEST_P(SparseBuild, HasTheSameBytesForAnyNumberOfThreads) {
  Rng rng(test::randomSeed());
  const Ground ground(GetParam(), rng.next(), 4);
  const auto pages = ground.some(rng);
  ground.build(pages, 1);
  const auto one = test::slurp(ground.path);
  ground.build(pages, 7);
  EXPECT_EQ(one, test::slurp(ground.path));
}

INSTANTIATE_TEST_SUITE_P(Frames, SparseBuild, testing::Values(FrameKind::kPlanar, FrameKind::kGeographic),
                         [](const auto& kind) { return kind.param == FrameKind::kPlanar ? "Planar" : "Geographic"; });

TEST(SparseBuildOfAWideLattice, CostsWhatIsThere) {
  constexpr uint32_t kSide = 200'000;
  const GridTopology grid = *sparseGrid(kSide, kSide, 10);
  proto::Frame frame;
  frame.axis_x_m = {1, 0};
  frame.axis_y_m = {0, 1};
  frame.height_quantum_m = 0.01;
  const proto::LatticeWindow deep{100'000, 60'000, 300, 200};
  const auto isWanted = [&](uint32_t, const proto::LatticeWindow& tile) {
    return tile.x <= deep.x + deep.width && deep.x <= tile.x + tile.width && tile.y <= deep.y + deep.height &&
           deep.y <= tile.y + tile.height;
  };
  const auto height = [](NodeId v) { return static_cast<int32_t>(1000 * std::sin(0.05 * v.x()) + v.y() % 97); };
  const test::TemporaryFolder folder;
  const auto report = buildSparseScene({grid, frame, pagesWhere(grid, isWanted), height}, {folder / "wide.fls", 2});
  ASSERT_TRUE(report.ok()) << report.error().message;
  EXPECT_LT(report->file_bytes, 8u << 20);
  const auto scene = *Scene::open(folder / "wide.fls");
  EXPECT_TRUE(verifyScene(folder / "wide.fls", 2)->sound());
  for (uint32_t x = deep.x; x < deep.x + deep.width; x += 7)
    EXPECT_EQ(scene->height(NodeId::at(x, deep.y + 5)), height(NodeId::at(x, deep.y + 5)));
  EXPECT_FALSE(scene->pages().hasPage(grid.slot(NodeId::at(150'001, 20'001))));
}

class SparseFile : public testing::Test {
 protected:
  Rng rng{test::randomSeed()};
  Ground ground{FrameKind::kPlanar, rng.next(), 3};
  std::vector<char> bytes;

  void SetUp() override {
    ground.build(ground.some(rng));
    bytes = test::slurp(ground.path);
  }
  proto::PageBlock* blocks() {
    return reinterpret_cast<proto::PageBlock*>(bytes.data() + test::headerOf(bytes).pages.offset);
  }
  size_t blockCount() { return test::headerOf(bytes).pages.bytes / sizeof(proto::PageBlock); }
  Result<std::shared_ptr<const Scene>> open(const FileHeader& header) {
    test::sealScene(bytes, header);
    test::spit(ground.path, bytes);
    return Scene::open(ground.path);
  }
};

TEST_F(SparseFile, HasVersionSeven) {
  EXPECT_EQ(test::headerOf(bytes).version, 7u);
  EXPECT_EQ(test::headerOf(test::slurp(ground.path)).sparse_levels, 6u);
}

// Whatever stands in the directory: the scene is refused, or reading all of it is harmless.
TEST_F(SparseFile, AnyForgedDirectoryIsRefusedOrHarmless) {
  const std::vector<char> sound = bytes;
  size_t refused = 0, opened = 0;
  for (int i = 0; i < 2000; ++i) {
    bytes = sound;
    auto* const directory = reinterpret_cast<char*>(blocks());
    const size_t at = rng.below(blockCount() * sizeof(proto::PageBlock));
    if (rng.below(2) == 0)  // the same number of pages elsewhere, or another key or place
      std::swap(directory[at], directory[at ^ 1]);
    else
      directory[at] = static_cast<char>(rng.below(3) == 0 ? rng.below(256) : directory[at] ^ 1 << rng.below(8));
    const auto scene = open(test::headerOf(bytes));
    if (!scene.ok()) {
      ++refused;
      continue;
    }
    ++opened;
    int64_t sum = 0;
    for (int k = 0; k < 500; ++k)
      sum += (*scene)->height(NodeId::at(static_cast<uint32_t>(rng.below(ground.grid.maxX() + 1)),
                                         static_cast<uint32_t>(rng.below(ground.grid.maxY() + 1))));
    const volatile int64_t keep = sum;
    static_cast<void>(keep);
  }
  EXPECT_GT(refused, 0u);
  EXPECT_GT(opened, 0u);
}

TEST_F(SparseFile, RefusesHeadersThatDoNotGoWithTheirPages) {
  const FileHeader sound = test::headerOf(bytes);
  const auto expectRefused = [&](const char* words, const auto& change) {
    FileHeader header = sound;
    change(header);
    const auto scene = open(header);
    ASSERT_FALSE(scene.ok()) << words;
    EXPECT_NE(scene.error().message.find(words), std::string::npos) << scene.error().message;
  };
  expectRefused("version does not go with its sparse levels", [](FileHeader& h) { h.version = 5; });
  expectRefused("version does not go with its sparse levels", [](FileHeader& h) { h.sparse_levels = 0; });
  expectRefused("sparse levels of", [](FileHeader& h) { h.sparse_levels = 99; });
  expectRefused("wrong size", [](FileHeader& h) { h.pages.bytes -= 8; });
  expectRefused("not in the file", [](FileHeader& h) { h.pages.offset = uint64_t{1} << 60; });
  expectRefused("not in the file", [](FileHeader& h) { h.pages.bytes = ~uint64_t{0} / 144 * 144; });
  expectRefused("not in the file", [](FileHeader& h) { h.pages.offset += kPageBytes; });
  expectRefused("directory of pages", [](FileHeader& h) { h.pages.offset -= kPageBytes; });
  expectRefused("not where they belong", [](FileHeader& h) { h.pages = {}; });
  expectRefused("wrong level", [](FileHeader& h) { h.sparse_levels -= 2; });
}

TEST_F(SparseFile, VerifyFindsPagesWithoutTheirParents) {
  const Ground deep(FrameKind::kPlanar, 7, 5);
  const auto scene = deep.build({deep.grid.slot(NodeId::at(71, 70))});
  std::vector<proto::PageBlock> closed(scene->pages().blocks().begin(), scene->pages().blocks().end());
  ASSERT_GT(closed.size(), 1u);
  closed.erase(closed.begin());  // of the coarsest sparse level
  uint64_t place = scene->pages().wholeSlots() / proto::kPageSlots;
  for (proto::PageBlock& block : closed) block.first = place, place += block.count();
  auto writer = SceneWriter::create(deep.path, {.shape = deep.grid.shape(),
                                                .frame = deep.frame,
                                                .heights = scene->heightRange(),
                                                .origin = {},
                                                .pages = closed});
  ASSERT_TRUE(writer.ok());
  const auto directory = *proto::PageDirectory::create(deep.grid, closed);
  directory.forEachPage([&](Slot first, uint64_t at) {
    const uint64_t from = scene->pages().placeOf(first);
    ASSERT_TRUE(writer->put(at * proto::kPageSlots, scene->records().subspan(from, proto::kPageSlots)).ok());
  });
  std::ranges::copy(scene->cornerHeights(), writer->corners().begin());
  std::ranges::copy(scene->centreHeights(), writer->centres().begin());
  ASSERT_TRUE(writer->finish().ok());
  const auto report = verifyScene(deep.path, 1);
  ASSERT_TRUE(report.ok());
  const auto names = [](const std::string& fault) { return fault.find("page of its parent") != std::string::npos; };
  EXPECT_TRUE(std::ranges::any_of(report->first_faults, names));
}

}  // namespace
}  // namespace foreland::terrain
