#include "terrain/store/verify.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdint>
#include <functional>

#include "terrain/store/format.h"
#include "tests/support/forged_scene.h"
#include "tests/support/scene.h"

namespace foreland::terrain {
namespace {

class Forged : public testing::Test {
 protected:
  test::TemporaryFolder folder;
  std::filesystem::path path = folder / "a.fls";
  std::vector<char> bytes;
  FileHeader header;

  void SetUp() override {
    test::FormulaSource source(40, 25, test::hills(3));
    ASSERT_TRUE(buildScene(source, {path}).ok());
    bytes = test::slurp(path);
    header = test::headerOf(bytes);
  }
  NodeRecord* nodes() { return reinterpret_cast<NodeRecord*>(bytes.data() + header.sections[kNodes].offset); }
  const proto::GridTopology grid = *proto::GridTopology::create(proto::GridTopology::shapeFor(40, 25));

  VerifyReport seal() {
    test::sealScene(bytes, header);
    test::spit(path, bytes);
    const auto report = verifyScene(path, 2);
    EXPECT_TRUE(report.ok());
    return *report;
  }
  void expectFault(const char* words) {
    const VerifyReport report = seal();
    ASSERT_FALSE(report.sound());
    const auto says = [&](const std::string& fault) { return fault.find(words) != std::string::npos; };
    EXPECT_TRUE(std::any_of(report.first_faults.begin(), report.first_faults.end(), says))
        << report.first_faults.front();
  }
  static void setError(NodeRecord& r, uint8_t error) {
    r = NodeRecord::of(r.height(), r.displacement(), {error}, r.radius());
  }
  static void setRadius(NodeRecord& r, uint8_t radius) {
    r = NodeRecord::of(r.height(), r.displacement(), r.error(), {radius});
  }
  // A node inside the data with children of nonzero error.
  proto::Slot someParent() { return grid.slot(proto::NodeId::at(12, 8)); }
};

TEST_F(Forged, SoundSceneIsSoundAndEverySlotIsCounted) {
  const VerifyReport report = seal();
  EXPECT_TRUE(report.sound());
  EXPECT_EQ(report.nodes + report.padding, grid.slotCount());
  EXPECT_EQ(report.blocks, blockCount(header.sections[kChecksums]));
  EXPECT_TRUE(openVerified(path).ok());
}

TEST_F(Forged, SmallerErrorThanAChildIsFound) {
  setError(nodes()[someParent()], 0);
  expectFault("smaller error than its child");
}

TEST_F(Forged, SphereThatDoesNotHoldAChildsIsFound) {
  setRadius(nodes()[someParent()], 0);
  expectFault("sphere that does not hold that of its child");
}

TEST_F(Forged, DisplacementThatIsNotFromTheMiddleIsFound) {
  nodes()[someParent()].bits ^= uint64_t{1} << 24;
  expectFault("not from the middle of its edge");
}

TEST_F(Forged, PageWithTwoRadiiIsFound) {
  NodeRecord& record = nodes()[someParent()];
  setRadius(record, static_cast<uint8_t>(record.radius().value + 1));
  expectFault("another radius than its page");
}

TEST_F(Forged, HeightOutsideTheRangeIsFound) {
  NodeRecord& record = nodes()[someParent()];
  record = NodeRecord::of(1 << 21, record.displacement(), record.error(), record.radius());
  expectFault("outside the scene's range");
}

TEST_F(Forged, DirtyPaddingIsFound) {
  proto::Slot padding = 0;
  while (!(grid.node(padding) == proto::NodeId{})) ++padding;
  nodes()[padding].bits = 1;
  expectFault("padding");
}

TEST_F(Forged, BaseHeightOutsideTheRangeIsFound) {
  bytes[header.sections[kCentres].offset + 2] = 0x30;  // one beyond 2^22 is refused when the file is opened
  EXPECT_FALSE(seal().sound());
}

TEST_F(Forged, FaultsAreTheSameForAnyNumberOfThreads) {
  for (proto::Slot slot = 0; slot < grid.slotCount(); slot += 3) setRadius(nodes()[slot], 0);
  const VerifyReport two = seal();
  for (unsigned threads : {1u, 5u}) {
    const auto report = verifyScene(path, threads);
    EXPECT_EQ(report->faults, two.faults);
    EXPECT_EQ(report->first_faults, two.first_faults);
  }
}

}  // namespace
}  // namespace foreland::terrain
