// The vertical datum in the scene file: it comes back, scenes without one are as they were, and damage is found.
#include <gtest/gtest.h>

#include <cmath>
#include <cstring>

#include "terrain/store/format.h"
#include "terrain/store/mapped_scene.h"
#include "terrain/store/verify.h"
#include "tests/support/files.h"
#include "tests/support/forged_scene.h"
#include "tests/support/scene.h"

namespace foreland::terrain {
namespace {

proto::VerticalDatum egm96() {
  return {proto::ZeroSurface::kGeoid, "EGM96", "EGM96", {{-5, -7}, {40, 30}, 2, 3, {50, 51, 52, 53, 54, 55}, 0.25}};
}

class DatumFile : public testing::Test {
 protected:
  test::TemporaryFolder folder;

  // Builds hills and opens them.
  std::shared_ptr<const MappedScene> build(const std::string& name, const proto::VerticalDatum& datum,
                                           const std::string& crs = "") const {
    test::FormulaSource source(20, 13, test::hills(7));
    source.info().vertical = datum;
    source.info().crs_wkt = crs;
    if (!datum.name.empty())
      source.info().inputs = {{"west.tif", {0, 0, 12, 13}, "EGM96", true, true},
                              {"east.tif", {8, 0, 12, 13}, "ellipsoid", false, false}};
    const auto report = buildScene(source, {folder / name});
    EXPECT_TRUE(report.ok()) << report.error().message;
    auto scene = MappedScene::open(folder / name);
    EXPECT_TRUE(scene.ok()) << scene.error().message;
    return *scene;
  }
};

TEST_F(DatumFile, GivesBackWhatIsStated) {
  const auto scene = build("scene.fls", egm96());
  EXPECT_EQ(scene->header().version, 6u);
  const proto::VerticalDatum& got = scene->vertical();
  EXPECT_EQ(got.zero_surface, proto::ZeroSurface::kGeoid);
  EXPECT_EQ(got.name, "EGM96");
  EXPECT_EQ(got.geoid, "EGM96");
  EXPECT_EQ(got.undulations.first, glm::dvec2(-5, -7));
  EXPECT_EQ(got.undulations.step, glm::dvec2(40, 30));
  EXPECT_EQ(got.undulations.metres, egm96().undulations.metres);
  EXPECT_EQ(got.undulations.max_error_m, 0.25);
  ASSERT_EQ(scene->inputs().size(), 2u);
  EXPECT_EQ(scene->inputs()[0].name, "west.tif");
  EXPECT_TRUE(scene->inputs()[0].may_have_voids);
  EXPECT_EQ(scene->inputs()[0].residual_m, 0.5 * scene->frame().height_quantum_m) << "rounding";
  EXPECT_EQ(scene->inputs()[1].vertical, "ellipsoid");
  EXPECT_EQ(scene->inputs()[1].window, (proto::LatticeWindow{8, 0, 12, 13}));
  EXPECT_TRUE(std::isnan(scene->inputs()[1].residual_m)) << "it was not on the lattice";
  EXPECT_TRUE(openVerified(folder / "scene.fls", 1).ok());
}

TEST_F(DatumFile, OfASceneThatStatesNoneIsAsItWas) {
  const auto scene = build("scene.fls", {});
  EXPECT_EQ(scene->header().version, 4u);
  EXPECT_EQ(scene->header().datum, SectionRange{});
  EXPECT_EQ(scene->vertical().zero_surface, proto::ZeroSurface::kUnstated);
  const std::vector<char> bytes = test::slurp(folder / "scene.fls");
  EXPECT_TRUE(std::all_of(bytes.begin() + 364, bytes.begin() + kPageBytes, [](char byte) { return byte == 0; }));
}

TEST_F(DatumFile, SeasAreOfGlobesAlone) {
  build("scene.fls", {});
  auto bytes = test::slurp(folder / "scene.fls");
  FileHeader header = test::headerOf(bytes);
  header.has_sea = 1;
  test::sealScene(bytes, header);
  test::spit(folder / "forged.fls", bytes);
  EXPECT_FALSE(MappedScene::open(folder / "forged.fls").ok());
}

TEST_F(DatumFile, IsInTheScenesId) {
  const auto unstated = build("unstated.fls", {}), stated = build("stated.fls", egm96());
  proto::VerticalDatum other = egm96();
  other.undulations.metres[3] += 0.001f;
  const auto shifted = build("shifted.fls", other);
  EXPECT_NE(unstated->id(), stated->id());
  EXPECT_NE(stated->id(), shifted->id());
  EXPECT_EQ(stated->id(), build("again.fls", egm96())->id());
}

TEST_F(DatumFile, TheSectionsBeforeItAreThoseWithoutIt) {
  const auto unstated = build("unstated.fls", {}), stated = build("stated.fls", egm96());
  for (uint32_t kind = 0; kind < kChecksums; ++kind) {
    const SectionRange &a = unstated->header().sections[kind], &b = stated->header().sections[kind];
    ASSERT_EQ(a, b);
    EXPECT_EQ(std::memcmp(unstated->file().data() + a.offset, stated->file().data() + b.offset, a.bytes), 0) << kind;
  }
  EXPECT_EQ(unstated->header().tiles, stated->header().tiles);
}

TEST_F(DatumFile, IsTheReferenceSystemsWhereTheSceneStatesNone) {
  const auto compound =
      build("a.fls", {}, "COMPOUNDCRS[\"x\",GEOGCRS[\"y\"],VERTCRS[\"NAVD88 height\",VDATUM[\"z\"]]]");
  EXPECT_EQ(compound->header().version, 4u);
  EXPECT_EQ(compound->vertical().zero_surface, proto::ZeroSurface::kGeoid);
  EXPECT_EQ(compound->vertical().name, "NAVD88 height");
  EXPECT_TRUE(compound->vertical().undulations.isEmpty());
  EXPECT_EQ(build("b.fls", {}, "GEOGCRS[\"WGS 84\",CS[ellipsoidal,3]]")->vertical().zero_surface,
            proto::ZeroSurface::kEllipsoid);
  EXPECT_EQ(build("c.fls", {}, "GEOGCRS[\"WGS 84\",CS[ellipsoidal,2]]")->vertical().zero_surface,
            proto::ZeroSurface::kUnstated);
}

TEST_F(DatumFile, AnyFlippedByteIsRefusedOrFound) {
  const auto scene = build("scene.fls", egm96());
  const SectionRange section = scene->header().datum;
  const std::vector<char> bytes = test::slurp(folder / "scene.fls");
  for (uint64_t at = section.offset; at < section.offset + section.bytes; ++at) {
    auto damaged = bytes;
    damaged[at] = static_cast<char>(damaged[at] ^ (1 << at % 8));
    test::spit(folder / "flip.fls", damaged);
    EXPECT_FALSE(openVerified(folder / "flip.fls", 1).ok()) << "byte " << at;
  }
}

TEST(DatumSection, AnyBytesEndInADatumOrAnError) {
  const Bytes good = encodeDatum({egm96(), {{"west.tif", "EGM96", {0, 0, 12, 13}, true, 0.5}}});
  ASSERT_TRUE(decodeDatum(good, 20, 13).ok());
  EXPECT_FALSE(decodeDatum(good, 11, 13).ok()) << "an input beyond the samples";
  for (size_t size = 0; size < good.size(); ++size)
    EXPECT_FALSE(decodeDatum(ByteSpan(good).first(size), 20, 13).ok()) << size;
  Rng rng(8);
  for (int i = 0; i < 20000; ++i) {
    Bytes forged = good;
    for (uint64_t flips = 1 + rng.below(3); flips > 0; --flips)
      forged[rng.below(forged.size())] = static_cast<uint8_t>(rng.next());
    if (const auto datum = decodeDatum(forged, 20, 13); datum.ok()) { EXPECT_TRUE(datum->vertical.validate().ok()); }
  }
}

}  // namespace
}  // namespace foreland::terrain
