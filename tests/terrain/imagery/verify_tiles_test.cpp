#include "terrain/imagery/verify_tiles.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "proto/imagery/relief_codec.h"
#include "tests/support/forged_scene.h"
#include "tests/support/scene.h"

namespace foreland::terrain {
namespace {

class ForgedTiles : public testing::Test {
 protected:
  test::TemporaryFolder folder;
  std::vector<char> bytes;
  FileHeader header;

  void SetUp() override {
    test::FormulaSource source(300, 260, test::hills(3));
    ASSERT_TRUE(buildScene(source, {.output = folder / "a.fls"}).ok());
    bytes = test::slurp(folder / "a.fls");
    header = test::headerOf(bytes);
  }
  // The entry of a tile by its number; 0 to 3 are the finest level's, 4 is the coarsest.
  StoredTile* entry(size_t number) {
    return reinterpret_cast<StoredTile*>(bytes.data() + header.tiles.offset + sizeof(TileSectionStart) +
                                         sizeof(StoredLayer)) +
           number;
  }
  std::span<uint8_t> coded(size_t number) {
    return {reinterpret_cast<uint8_t*>(bytes.data()) + header.tiles.offset + entry(number)->offset,
            entry(number)->bytes};
  }
  TilesReport report() {
    test::sealScene(bytes, header);
    test::spit(folder / "b.fls", bytes);
    const auto found = verifyTiles(folder / "b.fls", 2);
    EXPECT_TRUE(found.ok());
    return *found;
  }
  void expectFault(const char* words) {
    const TilesReport found = report();
    ASSERT_GT(found.faults, 0u);
    const auto says = [&](const std::string& fault) { return fault.find(words) != std::string::npos; };
    EXPECT_TRUE(std::ranges::any_of(found.first_faults, says)) << found.first_faults.front();
  }
};

TEST_F(ForgedTiles, SoundOnesAreSound) { EXPECT_EQ(report().faults, 0u); }

TEST_F(ForgedTiles, HeightsThatAreNotTheSamplesAreFound) {
  coded(1)[coded(1).size() / 2] ^= 0x10;
  expectFault("tile (1, 0) of level 0 of layer 0");
}

TEST_F(ForgedTiles, ACoarserTileThatIsNotTheMeanIsFound) {
  // Level ground takes few bytes; those after it stay unused.
  const Bytes level = proto::encodeRelief(std::vector<int32_t>(proto::kTileTexels, 1000));
  ASSERT_LT(level.size(), coded(4).size());
  std::ranges::copy(level, coded(4).begin());
  entry(4)->bytes = static_cast<uint32_t>(level.size());
  expectFault("not the mean of those of the finer level");
}

TEST_F(ForgedTiles, BoundsThatDoNotHoldTheGroundAreFound) {
  entry(2)->lowest_m += 100;
  expectFault("not within its bounds");
}

TEST_F(ForgedTiles, ANarrowConeIsFound) {
  entry(3)->half_angle = 2;
  expectFault("normals outside its cone");
}

TEST_F(ForgedTiles, BoundsThatDoNotHoldAFinerTilesAreFound) {
  entry(4)->highest_m -= 200;
  expectFault("do not hold those of a finer one");
}

TEST_F(ForgedTiles, AMissingTileIsFound) {
  *entry(4) = {};
  expectFault("the coarsest, but it is not stored");
}

TEST_F(ForgedTiles, ALayerThatDoesNotFitTheSamplesIsFound) {
  auto* layer = reinterpret_cast<StoredLayer*>(bytes.data() + header.tiles.offset + sizeof(TileSectionStart));
  layer->width -= 1;
  expectFault("does not fit the samples");
}

}  // namespace
}  // namespace foreland::terrain
