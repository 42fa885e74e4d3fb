#include "terrain/store/scene.h"

#include <gtest/gtest.h>

#include "terrain/store/format.h"
#include "terrain/store/verify.h"
#include "tests/support/files.h"
#include "tests/support/scene.h"

namespace foreland::terrain {
namespace {

class SceneFile : public testing::Test {
 protected:
  test::TemporaryFolder folder;
  std::filesystem::path path = folder / "scene.fls";
  std::vector<char> bytes;

  void SetUp() override {
    test::FormulaSource source(20, 13, test::hills(7), proto::FrameKind::kGeographic);
    source.info().crs_wkt = "GEOGCRS[\"nowhere\"]";
    source.info().notes = {"first note", "second\nnote"};
    ASSERT_TRUE(buildScene(source, {path}).ok());
    bytes = test::slurp(path);
  }
  // Reads everything a server might, so that a sanitizer sees every access.
  static void touch(const Scene& scene) {
    int64_t sum = scene.heightRange().lowest;
    for (uint32_t y = 0; y <= scene.grid().maxY(); ++y)
      for (uint32_t x = 0; x <= scene.grid().maxX(); ++x) sum += scene.height(proto::NodeId::at(x, y));
    for (const NodeRecord& node : scene.records()) sum += node.error().value + node.radius().value;
    volatile int64_t kept = sum;
    (void)kept;
  }
};

TEST_F(SceneFile, GivesBackWhatWasBuilt) {
  const auto scene = Scene::open(path);
  ASSERT_TRUE(scene.ok());
  EXPECT_EQ((*scene)->grid().shape(), proto::GridTopology::shapeFor(20, 13));
  proto::Frame frame = test::makeFrame(proto::FrameKind::kGeographic, 20, 13);
  EXPECT_EQ((*scene)->frame(), frame);
  EXPECT_EQ((*scene)->origin().title, "formula");
  EXPECT_EQ((*scene)->origin().crs_wkt, "GEOGCRS[\"nowhere\"]");
  EXPECT_EQ((*scene)->origin().notes, (std::vector<std::string>{"first note", "second\nnote"}));
  EXPECT_NE((*scene)->id(), 0u);
}

TEST_F(SceneFile, HasTheSameBytesForAnyNumberOfThreads) {
  for (unsigned threads : {1u, 2u, 7u}) {
    test::FormulaSource source(150, 131, test::hills(9), proto::FrameKind::kPlanar);
    ASSERT_TRUE(buildScene(source, {folder / std::to_string(threads), 0.1, threads}).ok());
  }
  EXPECT_EQ(test::slurp(folder / "1"), test::slurp(folder / "2"));
  EXPECT_EQ(test::slurp(folder / "1"), test::slurp(folder / "7"));
}

TEST_F(SceneFile, CutShortAnywhereIsRefused) {
  for (size_t size = 0; size < bytes.size(); size += 1 + size / 40) {
    test::spit(folder / "cut.fls", {bytes.begin(), bytes.begin() + static_cast<ptrdiff_t>(size)});
    const auto scene = Scene::open(folder / "cut.fls");
    ASSERT_FALSE(scene.ok()) << size;
    EXPECT_NE(scene.error().message.find("cut.fls"), std::string::npos);
  }
  auto longer = bytes;
  longer.push_back(0);
  test::spit(folder / "cut.fls", longer);
  EXPECT_FALSE(Scene::open(folder / "cut.fls").ok());
}

TEST_F(SceneFile, AnyFlippedByteIsRefusedOrFoundAndNeverHarms) {
  Rng rng(3);
  for (int i = 0; i < 3000; ++i) {
    const size_t at = i < 400 ? static_cast<size_t>(i) : rng.below(bytes.size());
    auto damaged = bytes;
    damaged[at] = static_cast<char>(damaged[at] ^ (1 << rng.below(8)));
    test::spit(folder / "flip.fls", damaged);
    if (const auto scene = Scene::open(folder / "flip.fls"); scene.ok()) touch(**scene);
    EXPECT_FALSE(openVerified(folder / "flip.fls", 1).ok()) << "byte " << at;
  }
}

// Damage that a checksum cannot see: the header is made to agree with itself again.
TEST_F(SceneFile, ForgedHeadersAreRefusedOrHarmless) {
  Rng rng(4);
  int opened = 0;
  for (int i = 0; i < 3000; ++i) {
    auto forged = bytes;
    const size_t at = 16 + rng.below(sizeof(FileHeader) - 16);
    forged[at] = static_cast<char>(rng.below(4) == 0 ? rng.below(256) : forged[at] ^ (1 << rng.below(8)));
    FileHeader header;
    std::memcpy(&header, forged.data(), sizeof(header));
    const auto table_bytes = reinterpret_cast<const uint8_t*>(forged.data());
    if (header.sections[kChecksums].offset < forged.size() &&
        header.sections[kChecksums].bytes <= forged.size() - header.sections[kChecksums].offset)
      header.scene_id =
          contentId(header, {table_bytes + header.sections[kChecksums].offset, header.sections[kChecksums].bytes});
    header.header_checksum = headerChecksum(header);
    std::memcpy(forged.data(), &header, sizeof(header));
    test::spit(folder / "forged.fls", forged);
    if (const auto scene = Scene::open(folder / "forged.fls"); scene.ok()) touch(**scene), ++opened;
  }
  EXPECT_GT(opened, 0);
}

TEST_F(SceneFile, RandomBytesAfterTheMagicAreRefused) {
  Rng rng(5);
  for (int i = 0; i < 200; ++i) {
    std::vector<char> random(kPageBytes + rng.below(10000));
    for (char& byte : random) byte = static_cast<char>(rng.next());
    if (i % 2) std::copy(kSceneMagic.begin(), kSceneMagic.end(), random.begin());
    test::spit(folder / "random.fls", random);
    EXPECT_FALSE(Scene::open(folder / "random.fls").ok());
  }
}

TEST_F(SceneFile, MissingFoldersAndOtherThingsAreNamedInTheError) {
  for (const std::filesystem::path& bad :
       {folder / "missing.fls", folder.path(), std::filesystem::path("/dev/null"), std::filesystem::path("")}) {
    const auto scene = Scene::open(bad);
    ASSERT_FALSE(scene.ok()) << bad;
    EXPECT_NE(scene.error().message.find(bad.string()), std::string::npos);
  }
}

}  // namespace
}  // namespace foreland::terrain
