// Scenes of whole bodies: heights are the source's wherever a vertex is, whichever face names it; fine where insets are
// and nowhere else; sound; and as far from samples as they state.
#include "terrain/pipeline/globe_build.h"

#include <gtest/gtest.h>

#include <cmath>
#include <glm/geometric.hpp>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "base/rng.h"
#include "terrain/geo/geodesy.h"
#include "terrain/store/scene.h"
#include "terrain/store/verify.h"
#include "tests/support/files.h"
#include "tests/support/forged_scene.h"
#include "tests/support/seed.h"

namespace foreland::terrain {
namespace {

using proto::NodeId;

constexpr double kRadius_m = 20'000, kInset_rad = 0.05;

// Hills of a small flat body, with a cap of finer samples on them.
class Formula final : public GlobeSource {
 public:
  explicit Formula(const glm::dvec3& inset) : inset_(glm::normalize(inset)) {
    info_.semi_major_m = kRadius_m;
    info_.flattening = 0.05;
    info_.title = "formula";
    info_.inputs = {{.files = {"cap"}, .vertical = {}, .spacing_m = 62},
                    {.files = {"base"}, .vertical = {}, .spacing_m = 492}};
  }

  static double metres(const glm::dvec3& direction) {
    const glm::dvec3 n = glm::normalize(direction);
    return 90 * std::sin(11 * n.x + 3 * n.z) + 40 * std::cos(37 * n.y - 5 * n.x);
  }
  const GlobeInfo& info() const override { return info_; }
  GlobeHeight heightAt(const glm::dvec3& direction) const override {
    return {metres(direction), glm::dot(glm::normalize(direction), inset_) > std::cos(kInset_rad) ? 0 : 1};
  }
  double spacingIn(const GlobePatch& patch) const override {
    return std::acos(std::min(1.0, glm::dot(patch.middle, inset_))) <= patch.angle_rad + kInset_rad ? 62 : 492;
  }
  uint32_t rowsOf(size_t) const override { return static_cast<uint32_t>(samples.size()); }
  void samplesOf(size_t input, uint32_t row, std::vector<GlobeSample>& out) const override {
    if (heightAt(samples[row].direction).owner == static_cast<int>(input)) out.push_back(samples[row]);
  }

  std::vector<GlobeSample> samples{{glm::dvec3(0, 0, 1), metres({0, 0, 1})}};

 private:
  GlobeInfo info_;
  glm::dvec3 inset_;
};

struct Built {
  explicit Built(const Formula& source, double quantum_m = 0.1, bool has_sea = false,
                 std::optional<double> residual_m = {}) {
    const auto report = buildGlobe(
        source,
        {.output = path, .height_quantum_m = quantum_m, .threads = 2, .residual_m = residual_m, .has_sea = has_sea});
    if (report.ok()) nodes = report->nodes, warnings = report->warnings;
    EXPECT_TRUE(report.ok()) << (report.ok() ? "" : report.error().message);
    const auto opened = Scene::open(path);
    EXPECT_TRUE(opened.ok()) << (opened.ok() ? "" : opened.error().message);
    if (opened.ok()) scene = *opened;
  }
  const test::TemporaryFolder folder;
  const std::filesystem::path path = folder / "globe.fls";
  std::shared_ptr<const Scene> scene;
  uint64_t nodes = 0;
  std::vector<std::string> warnings;
};

glm::dvec3 anyDirection(Rng& rng) { return {rng.uniform(-1, 1), rng.uniform(-1, 1), rng.uniform(-1, 1)}; }

// The direction of a place on a face's square, from GeographicLib's latitude and longitude of where the frame puts it.
glm::dvec3 normalOf(const Scene& scene, const glm::dvec3& position) {
  const proto::Geodetic at = referencePlace({scene.frame().semi_major_m, scene.frame().flattening}, position);
  return {std::cos(at.latitude_rad) * std::cos(at.longitude_rad),
          std::cos(at.latitude_rad) * std::sin(at.longitude_rad), std::sin(at.latitude_rad)};
}

TEST(GlobeBuild, HasTheSourcesHeightsAtEveryVertexAndIsSound) {
  Rng rng(test::randomSeed());
  const Built built(Formula(anyDirection(rng)));
  ASSERT_TRUE(built.scene);
  const Scene& scene = *built.scene;
  EXPECT_EQ(scene.grid().shape().root_log2, 9u);
  const auto report = verifyScene(built.path, 2);
  ASSERT_TRUE(report.ok());
  EXPECT_TRUE(report->sound()) << report->first_faults.front();
  const proto::FrameTransform transform(scene.frame());
  size_t checked = 0;
  scene.pages().forEachPage([&](proto::Slot first, uint64_t) {
    for (proto::Slot slot = first; slot < first + proto::kPageSlots; slot += 5) {
      const NodeId n = scene.grid().node(slot);
      if (n == NodeId{}) continue;
      const double height_m = scene.height(n) * 0.1;
      const glm::dvec3 normal = normalOf(scene, transform.vertexOfGlobe(n.x(), n.y(), height_m));
      ASSERT_NEAR(height_m, Formula::metres(normal), 0.05 + 1e-6) << n.x() << ", " << n.y();
      ++checked;
    }
  });
  EXPECT_GT(checked, 6000u);
}

TEST(GlobeBuild, ASeaIsANumberInTheHeaderThatKnowsNoOther) {
  const Formula source(glm::dvec3(1, 0.2, 0.1));
  const Built dry(source), wet(source, 0.1, true);
  ASSERT_TRUE(dry.scene && wet.scene);
  EXPECT_FALSE(dry.scene->hasSea());
  EXPECT_TRUE(wet.scene->hasSea());
  EXPECT_NE(dry.scene->id(), wet.scene->id());
  const std::vector<char> bytes = test::slurp(dry.path), wet_bytes = test::slurp(wet.path);
  FileHeader header = test::headerOf(bytes);
  EXPECT_EQ(header.has_sea, 0u);
  auto forged = bytes;
  header.has_sea = 1;
  test::sealScene(forged, header);
  EXPECT_EQ(forged, wet_bytes) << "it differs in more";
  for (const uint32_t other : {2u, 256u, ~0u}) {
    header.has_sea = other;
    test::sealScene(forged, header);
    test::spit(wet.folder / "forged.fls", forged);
    const auto opened = Scene::open(wet.folder / "forged.fls");
    ASSERT_FALSE(opened.ok()) << other;
    EXPECT_NE(opened.error().message.find("a sea that this version does not know"), std::string::npos);
  }
}

TEST(GlobeBuild, IsFineWhereTheInsetIsAndNowhereElse) {
  Rng rng(test::randomSeed());
  for (int i = 0; i < 4; ++i) {
    // Over an edge of the cube in every other turn, and over a corner.
    const glm::dvec3 middle = i == 3 ? glm::dvec3(1, -1, 1) : i % 2 == 0 ? anyDirection(rng) : glm::dvec3(1, 0.3, 1);
    const Built built{Formula(middle)};
    ASSERT_TRUE(built.scene);
    const Scene& scene = *built.scene;
    const proto::GridTopology& grid = scene.grid();
    const proto::FrameTransform transform(scene.frame());
    for (int k = 0; k < 3000; ++k) {
      const bool is_near = k % 2 == 0;
      const glm::dvec3 d = is_near
                               ? glm::normalize(glm::normalize(middle) + 0.7 * kInset_rad * anyDirection(rng) / 1.74)
                               : glm::normalize(anyDirection(rng));
      const double off_rad = std::acos(std::min(1.0, glm::dot(d, glm::normalize(middle))));
      const proto::LatticePosition at = transform.toLattice(transform.spheroid().position(d, 0));
      const NodeId n = NodeId::at(static_cast<uint32_t>(at.x) | 1, static_cast<uint32_t>(at.y) | 1);  // a finest centre
      if (is_near) {
        EXPECT_TRUE(scene.pages().hasPage(grid.slot(n))) << n.x() << ", " << n.y();
      } else if (off_rad > 4 * kInset_rad + 0.2) {
        EXPECT_FALSE(scene.pages().hasPage(grid.slot(n))) << n.x() << ", " << n.y();
      }
    }
  }
}

TEST(GlobeBuild, StatesHowFarItIsFromSamples) {
  Rng rng(test::randomSeed());
  Formula source(glm::dvec3(1, 0.2, 0.1));
  const Built first(source);
  ASSERT_TRUE(first.scene);
  // At vertices it is as far as they are rounded.
  const proto::FrameTransform transform(first.scene->frame());
  source.samples.clear();
  for (int i = 0; i < 300; ++i) {
    const auto x = static_cast<uint32_t>(rng.below(6 * 64)) * 8, y = static_cast<uint32_t>(rng.below(64)) * 8;
    const glm::dvec3 d = normalOf(*first.scene, transform.vertexOfGlobe(x, y, 0));
    source.samples.push_back({d, Formula::metres(d)});
  }
  const Built exact(source);
  ASSERT_EQ(exact.scene->inputs().size(), 2u);
  EXPECT_LT(exact.scene->inputs()[1].residual_m, 0.1 + 1e-4);
  // One that is wrong shows by as much.
  size_t of_base = 0;
  while (source.heightAt(source.samples[of_base].direction).owner != 1 ||
         glm::dot(source.samples[of_base].direction, glm::normalize(glm::dvec3(1, 0.2, 0.1))) > 0.98)
    ++of_base;
  source.samples[of_base].metres += 7;
  const Built wrong(source);
  EXPECT_NEAR(wrong.scene->inputs()[1].residual_m, 7.05, 0.06);
}

TEST(GlobeBuild, IsAsDeepAsTheResidualThatIsAskedForTakes) {
  const uint64_t seed = test::randomSeed();
  Rng rng(seed);
  const glm::dvec3 middle = glm::normalize(anyDirection(rng));
  Formula source(middle);
  source.samples.clear();
  while (source.samples.size() < 4'000) {
    const glm::dvec3 d = glm::normalize(middle + kInset_rad * anyDirection(rng));
    if (source.heightAt(d).owner == 0) source.samples.push_back({d, Formula::metres(d)});
  }
  // More than the base is off them takes nothing; a millimetre is closer than a quarter of 62 m can be.
  uint64_t fewer = 0;
  for (const double residual_m : {100.0, 1.0, 0.25, 0.001}) {
    const Built built(source, 0.001, false, residual_m);
    ASSERT_TRUE(built.scene);
    const uint64_t deep = built.scene->pages().blocks().size();
    EXPECT_EQ(deep == 0, residual_m == 100) << "seed " << seed;
    EXPECT_GT(built.nodes, fewer) << residual_m << ", seed " << seed;
    fewer = built.nodes;
    const double stated_m = built.scene->inputs()[0].residual_m;
    EXPECT_EQ(stated_m <= residual_m + 0.001 + 1e-6, residual_m > 0.1) << stated_m << ", seed " << seed;
    EXPECT_EQ(built.warnings.empty(), residual_m > 0.1) << "seed " << seed;
    const auto report = verifyScene(built.path, 2);
    ASSERT_TRUE(report.ok());
    EXPECT_TRUE(report->sound()) << report->first_faults.front();
  }
  // A quarter of the distance between samples.
  EXPECT_EQ(depthOf(source.info(), 1.0)->deepest_log2, 11u);
}

TEST(GlobeBuild, RefusesWhatIsTooFine) {
  class Fine final : public GlobeSource {
   public:
    GlobeInfo about;
    const GlobeInfo& info() const override { return about; }
    GlobeHeight heightAt(const glm::dvec3&) const override { return {}; }
    double spacingIn(const GlobePatch&) const override { return 1; }
    uint32_t rowsOf(size_t) const override { return 0; }
    void samplesOf(size_t, uint32_t, std::vector<GlobeSample>&) const override {}
  } fine;
  fine.about.title = "x.tif";
  fine.about.inputs = {{.files = {"x.tif"}, .vertical = {}, .spacing_m = 30}};
  EXPECT_NE(depthOf(fine.about).error().message.find("--inset"), std::string::npos);
  fine.about.inputs = {{.files = {"x.tif"}, .vertical = {}, .spacing_m = 0.1},
                       {.files = {"b"}, .vertical = {}, .spacing_m = 9e4}};
  EXPECT_NE(depthOf(fine.about).error().message.find("gdal_translate"), std::string::npos);
  // Faces of 2^21 steps: what is finer has vertices whose names floats of meshes do not hold.
  fine.about.inputs[0].spacing_m = 4.8;
  EXPECT_EQ(depthOf(fine.about).value().deepest_log2, 21u);
  fine.about.inputs[0].spacing_m = 4.7;
  EXPECT_FALSE(depthOf(fine.about).ok());
}

}  // namespace
}  // namespace foreland::terrain
