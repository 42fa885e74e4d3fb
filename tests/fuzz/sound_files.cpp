#include <cmath>

#include "base/check.h"
#include "terrain/pipeline/build.h"
#include "terrain/store/mapped_scene.h"
#include "terrain/surface/bounds.h"
#include "terrain/surface/shapes.h"
#include "terrain/surface_store/write_surface.h"
#include "tests/fuzz/changed_file.h"
#include "tests/support/files.h"
#include "tests/support/scene.h"
#include "tests/support/sparse_scene.h"
#include "tests/support/surfaces.h"

namespace foreland::test {

namespace {

Bytes readWhole(const std::filesystem::path& path) {
  const std::vector<char> bytes = slurp(path);
  return {bytes.begin(), bytes.end()};
}

// With `pose_times`, of three poses.
void writeSurface(const std::filesystem::path& path, proto::MeshRule rule, uint32_t texels_a_side,
                  const std::vector<Time>& pose_times = {}) {
  terrain::TrueSurface sphere = *terrain::makeSphere(2, {rule, 2, 1e-3});
  if (!pose_times.empty()) addPoses(sphere, pose_times.size() - 1, 0.3, 0.1, 1);
  const auto records = terrain::computeBounds(sphere, {.threads = 1});
  const auto atlas = proto::AtlasLayout::of(sphere.topology.base().faceCount(), texels_a_side);
  const std::vector<terrain::Texel> texels(uint64_t{atlas.width()} * atlas.height(), 0xff808080);
  const auto written = terrain::writeSurface(path, {.surface = sphere,
                                                    .pose_times = pose_times,
                                                    .records = records,
                                                    .atlas = texels_a_side > 0 ? atlas : proto::AtlasLayout{},
                                                    .texels = texels,
                                                    .about = {"sphere", {}, {"a note"}}});
  CHECK_TRUE(written.ok());
}

SoundFile sceneFile(uint32_t side, proto::FrameKind kind, std::vector<terrain::ObjectRequest> objects,
                    terrain::PageCoding page_coding = terrain::PageCoding::kPlain) {
  const TemporaryFolder folder;
  FormulaSource source(side, side, hills(1), kind);
  source.info().crs_wkt = "ENGCRS[\"nowhere\"]";
  const auto built =
      terrain::buildScene(source, {.output = folder / "scene.fls",
                                   .height_quantum_m = 0.1,
                                   .threads = 1,
                                   .additions = {.page_coding = page_coding, .objects = std::move(objects)}});
  CHECK_TRUE(built.ok());
  return SoundFile(readWhole(folder / "scene.fls"));
}

SoundFile movingSceneFile(proto::EpochBlend blend) {
  const TemporaryFolder folder;
  std::vector<terrain::ObjectRequest> objects;
  if (blend != proto::EpochBlend::kCatmullRom) {
    const auto model = folder / "model.fls";
    writeSurface(model, proto::MeshRule::kBisection, 0, {Time{0}, Time{1000}, Time{3000}});
    objects = {{model, {10, 20}}, {model, {-20, 10}, 1, 30, 2}};
  }
  FormulaSource source(9, 9, hills(1));
  FormulaSource first = windowSource(source, {0, 0, 2, 2}, hills(1)),
                second = windowSource(source, {1, 2, 6, 5}, hills(2)),
                third = windowSource(source, {3, 3, 6, 6}, hills(3));
  const auto built = terrain::buildScene(
      source, {.output = folder / "scene.fls",
               .threads = 1,
               .epochs = {{Time{0}, "first", &first}, {Time{1000}, "second", &second}, {Time{3000}, "third", &third}},
               .epoch_blend = blend,
               .additions = {.objects = std::move(objects)}});
  CHECK_TRUE(built.ok());
  return SoundFile(readWhole(folder / "scene.fls"));
}

SoundFile sparseSceneFile() {
  const auto scene = makeSparseScene(70, 40, hills(1), proto::FrameKind::kPlanar, 2, {{20, 20, 4}});
  const ByteSpan bytes = dynamic_cast<const terrain::MappedScene&>(*scene).file();
  return SoundFile(Bytes(bytes.begin(), bytes.end()));
}

SoundFile surfaceFile(proto::MeshRule rule, uint32_t texels_a_side, const std::vector<Time>& pose_times = {}) {
  const TemporaryFolder folder;
  writeSurface(folder / "surface.fls", rule, texels_a_side, pose_times);
  return SoundFile(readWhole(folder / "surface.fls"));
}

std::vector<SoundFile> makeScenes() {
  const TemporaryFolder folder;
  const auto model = folder / "model.fls";
  writeSurface(model, proto::MeshRule::kQuadrisection, 4);
  std::vector<SoundFile> scenes;
  scenes.push_back(sceneFile(6, proto::FrameKind::kPlanar, {}));
  scenes.push_back(sceneFile(9, proto::FrameKind::kGeographic, {}));
  scenes.push_back(sceneFile(9, proto::FrameKind::kPlanar, {{model, {10, 20}}, {model, {-20, 10}, 1, 30, 2}}));
  for (const auto blend : {proto::EpochBlend::kLinear, proto::EpochBlend::kCatmullRom, proto::EpochBlend::kBSpline})
    scenes.push_back(movingSceneFile(blend));
  scenes.push_back(sparseSceneFile());
  scenes.push_back(sceneFile(20, proto::FrameKind::kPlanar, {}, terrain::PageCoding::kCoded));
  return scenes;
}

std::vector<SoundFile> makeSurfaces() {
  std::vector<SoundFile> surfaces;
  for (const auto rule : {proto::MeshRule::kQuadrisection, proto::MeshRule::kBisection})
    for (const uint32_t texels_a_side : {0u, 4u}) surfaces.push_back(surfaceFile(rule, texels_a_side));
  surfaces.push_back(surfaceFile(proto::MeshRule::kQuadrisection, 0, {Time{-5}, Time{0}, Time{70}}));
  return surfaces;
}

}  // namespace

const std::vector<SoundFile>& soundScenes() {
  static const std::vector<SoundFile> scenes = makeScenes();
  return scenes;
}

const std::vector<SoundFile>& soundSurfaces() {
  static const std::vector<SoundFile> surfaces = makeSurfaces();
  return surfaces;
}

}  // namespace foreland::test
