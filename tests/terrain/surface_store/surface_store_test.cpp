// The file of a surface: what is written comes back, what is damaged is found, what is forged does no harm.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <filesystem>

#include "base/rng.h"
#include "terrain/store/scene.h"
#include "terrain/surface/bounds.h"
#include "terrain/surface_store/fill_gutters.h"
#include "terrain/surface_store/mapped_surface.h"
#include "terrain/surface_store/write_surface.h"
#include "tests/support/base_meshes.h"
#include "tests/support/files.h"
#include "tests/support/surface_file.h"
#include "tests/support/surfaces.h"

namespace foreland::terrain {
namespace {

// Whether a file can be opened of which a header is changed whose checksums are then made to hold.
template <class Change>
bool opensForged(auto file, const std::filesystem::path& path, const Change& change) {
  SurfaceHeader header;
  std::memcpy(&header, file.data(), sizeof(header));
  change(header);
  const SectionRange& sums = header.sections[kSurfaceChecksums];
  header.scene_id = contentId(header, {reinterpret_cast<const uint8_t*>(file.data()) + sums.offset, sums.bytes});
  header.header_checksum = headerChecksum(header);
  std::memcpy(file.data(), &header, sizeof(header));
  test::spit(path, file);
  return MappedSurface::open(path).ok();
}

// A bumpy surface with its bounds, and texels from a seed.
struct Made {
  TrueSurface surface;
  std::vector<proto::SurfaceRecord> records;
  proto::AtlasLayout atlas;
  std::vector<Texel> texels;
  SceneOrigin about{"made", {}, {"one", "two"}, 0};

  std::vector<Time> pose_times{};

  SurfaceContent content() const {
    return {.surface = surface,
            .pose_times = pose_times,
            .records = records,
            .atlas = atlas,
            .texels = texels,
            .about = about};
  }
};

Made makeContent(const test::NamedBase& base, proto::MeshRule rule, uint32_t halvings, size_t poses = 0) {
  Rng rng(7);
  std::vector<glm::dvec3> corners;
  for (uint32_t v = 0; v < base.vertices; ++v)
    corners.emplace_back(rng.uniform(-1, 1), rng.uniform(-1, 1), rng.uniform(-1, 1));
  auto surface = makeSurface(proto::MeshTopology::create({rule, halvings, base.vertices, base.faces}).value(), 0.001,
                             corners, [&](proto::NodeId, const glm::dvec3& middle) {
                               return middle + 0.02 * glm::dvec3(rng.uniform(), rng.uniform(), rng.uniform());
                             });
  Made made{std::move(surface).value(), {}, proto::AtlasLayout::of(static_cast<uint32_t>(base.faces.size()), 6), {}};
  test::addPoses(made.surface, poses, 0.3, 0.1, 8);
  for (size_t pose = 0; pose <= poses && poses > 0; ++pose)
    made.pose_times.push_back(Time{1'000'000 + 7 * static_cast<int64_t>(pose)});
  made.records = computeBounds(made.surface, {.threads = 1});
  made.texels.resize(uint64_t{made.atlas.width()} * made.atlas.height());
  for (Texel& texel : made.texels) texel = static_cast<Texel>(rng.next());
  fillGutters(made.atlas, made.surface.topology.base(), made.texels, 1);
  return made;
}

class SurfaceFile : public testing::Test {
 protected:
  test::TemporaryFolder folder;
  std::filesystem::path path = folder / "surface.fls";
  std::vector<char> bytes;

  void SetUp() override {
    const Made made = makeContent(test::torusBase(3, 3), proto::MeshRule::kQuadrisection, 2, 3);
    ASSERT_TRUE(writeSurface(path, made.content()).ok());
    bytes = test::slurp(path);
  }
  // Reads everything a server might, so that a sanitizer sees every access.
  static void touch(const MappedSurface& surface) {
    int64_t sum = 0;
    for (const glm::ivec3& p : surface.basePositions()) sum += p.x;
    for (proto::Slot slot = 0; slot < surface.topology().slotCount(); ++slot) {
      const proto::NodeId n = surface.topology().node(slot);
      if (!surface.topology().isBase(n)) sum += int64_t{surface.quanta(n).y} + surface.nodes()[slot].radius.bits;
    }
    for (const Texel texel : surface.texels()) sum += texel;
    for (const auto& moves : {surface.baseMoves(), surface.nodeMoves()})
      for (const glm::ivec3& move : moves) sum += move.z;
    for (const Time& time : surface.poseTimes()) sum += time.us;
    volatile int64_t kept = sum;
    (void)kept;
  }
};

TEST_F(SurfaceFile, GivesBackWhatWasWritten) {
  for (const auto& base : test::baseMeshes())
    for (const proto::MeshRule rule : {proto::MeshRule::kQuadrisection, proto::MeshRule::kBisection})
      for (const uint32_t halvings : {1u, 4u}) {
        SCOPED_TRACE(base.name);
        const Made made = makeContent(base, rule, halvings, halvings == 1 ? 3 : 0);
        const auto id = writeSurface(path, made.content());
        ASSERT_TRUE(id.ok()) << id.error().message;
        const auto read = MappedSurface::open(path);
        ASSERT_TRUE(read.ok()) << read.error().message;
        EXPECT_EQ((*read)->id(), *id);
        EXPECT_EQ((*read)->topology().shape(), made.surface.topology.shape());
        EXPECT_EQ((*read)->topology().base().isClosed(), base.closed);
        EXPECT_EQ((*read)->quantumMetres(), 0.001);
        EXPECT_TRUE(std::ranges::equal((*read)->basePositions(), made.surface.base));
        forEachNode(made.surface.topology,
                    [&](proto::NodeId n, proto::Slot) { EXPECT_EQ((*read)->quanta(n), made.surface.quanta(n)); });
        ASSERT_EQ((*read)->nodes().size(), made.records.size());
        EXPECT_EQ(std::memcmp((*read)->nodes().data(), made.records.data(), (*read)->nodes().size_bytes()), 0);
        EXPECT_TRUE(std::ranges::equal((*read)->texels(), made.texels));
        EXPECT_EQ((*read)->poseTimes(), made.pose_times);
        EXPECT_TRUE(std::ranges::equal((*read)->baseMoves(), baseMoves(made.surface)));
        EXPECT_TRUE(std::ranges::equal((*read)->nodeMoves(), nodeMoves(made.surface)));
        EXPECT_EQ((*read)->atlas(), made.atlas);
        EXPECT_EQ((*read)->about().notes, made.about.notes);
        const auto found = verifySurface(path);
        ASSERT_TRUE(found.ok());
        EXPECT_TRUE(found->sound()) << found->first_faults.front();
      }
}

// The origin has the place of zeros of older versions, and a version of its own, so surfaces without one are the same
// bytes as ever.
TEST_F(SurfaceFile, KeepsTheOriginInAVersionOfItsOwn) {
  const glm::dvec3 origin(562010, 5116007.5, -1200);
  for (const size_t poses : {0, 3}) {
    const Made made = makeContent(test::torusBase(3, 3), proto::MeshRule::kQuadrisection, 2, poses);
    const auto versionOf = [](const std::vector<char>& file) {
      uint32_t version = 0;
      std::memcpy(&version, file.data() + 8, sizeof(version));
      return version;
    };
    ASSERT_TRUE(writeSurface(path, made.content()).ok());
    const std::vector<char> plain = test::slurp(path);
    EXPECT_EQ(versionOf(plain), poses == 0 ? 2u : 3u);
    EXPECT_TRUE(std::all_of(plain.begin() + 208, plain.begin() + 4096, [](char byte) { return byte == 0; }));
    EXPECT_EQ((*MappedSurface::open(path))->origin(), glm::dvec3(0));

    SurfaceContent moved = made.content();
    moved.origin = origin;
    ASSERT_TRUE(writeSurface(path, moved).ok());
    const std::vector<char> file = test::slurp(path);
    EXPECT_EQ(versionOf(file), 4u);
    EXPECT_TRUE(std::equal(plain.begin() + 4096, plain.end(), file.begin() + 4096, file.end()));
    const auto read = MappedSurface::open(path);
    ASSERT_TRUE(read.ok()) << read.error().message;
    EXPECT_EQ((*read)->origin(), origin);
    EXPECT_EQ((*read)->poseTimes(), made.pose_times);
    EXPECT_TRUE(verifySurface(path)->sound());

    // Forged: an origin of an older version, of none, and one that is no number.
    const auto forge = [&](uint32_t version, double x) {
      return opensForged(file, folder / "forged.fls", [&](SurfaceHeader& header) {
        header.version = version, header.origin[0] = x, header.origin[1] = header.origin[2] = 0;
      });
    };
    EXPECT_TRUE(forge(4, 1));
    EXPECT_FALSE(forge(4, 0));
    EXPECT_FALSE(forge(4, 1e10));
    EXPECT_FALSE(forge(4, std::nan("")));
    EXPECT_FALSE(forge(poses == 0 ? 2 : 3, 1));
    EXPECT_TRUE(forge(poses == 0 ? 2 : 3, 0));
    EXPECT_FALSE(forge(poses == 0 ? 3 : 2, 0));
  }
}

// A sphere with two solids, of which the second has eight planes.
SurfaceContent withSolids(const TrueSurface& sphere, const std::vector<proto::SurfaceRecord>& records) {
  ConvexSolid cut = test::cubeAbout({0.1, -0.1, 0}, 0.3);
  cut.all_planes[6] = {glm::normalize(glm::dvec3(1, 1, 1)), -0.3};
  cut.all_planes[7] = {glm::normalize(glm::dvec3(-1, -1, 1)), -0.25};
  const ConvexSolid eight = makeSolid(cut.all_planes, 2);
  EXPECT_EQ(eight.plane_count, 8u);
  return {.surface = sphere, .records = records, .inner = {{test::cubeAbout({0, 0, 0}, 0.45), eight}, 0.375}};
}

TEST_F(SurfaceFile, KeepsInnerSolidsInAVersionOfItsOwn) {
  const TrueSurface sphere = *makeSphere(2, {proto::MeshRule::kQuadrisection, 3, 1e-3});
  const auto records = computeBounds(sphere, {.threads = 1});
  SurfaceContent content = withSolids(sphere, records);
  ASSERT_TRUE(writeSurface(folder / "plain.fls", {.surface = sphere, .records = records}).ok());
  for (const glm::dvec3& origin : {glm::dvec3(0), glm::dvec3(5, 6, 7)}) {
    content.origin = origin;
    ASSERT_TRUE(writeSurface(path, content).ok());
    const auto read = MappedSurface::open(path);
    ASSERT_TRUE(read.ok()) << read.error().message;
    EXPECT_EQ((*read)->header().version, 5u);
    EXPECT_EQ((*read)->origin(), origin);
    const InnerSolids& inner = (*read)->innerSolids();
    EXPECT_EQ(inner.volume_share, content.inner.volume_share);
    ASSERT_EQ(inner.solids.size(), content.inner.solids.size());
    for (size_t i = 0; i < inner.solids.size(); ++i) {
      EXPECT_TRUE(std::ranges::equal(inner.solids[i].planes(), content.inner.solids[i].planes()));
      for (int axis = 0; axis < 3; ++axis) {
        EXPECT_NEAR(inner.solids[i].low[axis], content.inner.solids[i].low[axis], 1e-5);
        EXPECT_NEAR(inner.solids[i].high[axis], content.inner.solids[i].high[axis], 1e-5);
      }
    }
    EXPECT_TRUE((*read)->isClosed());
    EXPECT_EQ((*read)->largestError(), largestError(sphere.topology, records));
    EXPECT_TRUE(verifySurface(path)->sound());
    const auto plain = test::slurp(folder / "plain.fls"), file = test::slurp(path);
    EXPECT_TRUE(std::equal(plain.begin() + 4096, plain.end(), file.begin() + 4096, file.end()));
  }
  EXPECT_TRUE((*MappedSurface::open(folder / "plain.fls"))->innerSolids().solids.empty());
}

TEST_F(SurfaceFile, VerifyFindsSolidsThatAreNotInside) {
  const TrueSurface sphere = *makeSphere(2, {proto::MeshRule::kQuadrisection, 3, 1e-3});
  const auto records = computeBounds(sphere, {.threads = 1});
  SurfaceContent content = withSolids(sphere, records);
  // In the full mesh, but not in the octahedron that is drawn from afar.
  content.inner.solids[1] = test::cubeAbout({0, 0, 0}, 0.8);
  ASSERT_TRUE(writeSurface(path, content).ok());
  const auto found = verifySurface(path);
  ASSERT_TRUE(found.ok()) << found.error().message;
  ASSERT_EQ(found->faults, 1u);
  EXPECT_EQ(found->first_faults.front(), "inner solid 1 is not inside of all that may be drawn of the surface");
}

// The header agrees with itself, but its solids are none.
TEST_F(SurfaceFile, ForgedSolidsAreRefused) {
  const TrueSurface sphere = *makeSphere(2, {proto::MeshRule::kQuadrisection, 3, 1e-3});
  const auto records = computeBounds(sphere, {.threads = 1});
  ASSERT_TRUE(writeSurface(path, withSolids(sphere, records)).ok());
  const auto file = test::slurp(path);
  const auto opens = [&](const auto& change) { return opensForged(file, folder / "forged.fls", change); };
  EXPECT_TRUE(opens([](SurfaceHeader&) {}));
  EXPECT_FALSE(opens([](SurfaceHeader& h) { h.solids = 1; })) << "one more than it says";
  EXPECT_FALSE(opens([](SurfaceHeader& h) { h.solids = 3; }));
  EXPECT_FALSE(opens([](SurfaceHeader& h) { h.solids = 5; }));
  EXPECT_FALSE(opens([](SurfaceHeader& h) { h.reserved = 1; }));
  EXPECT_FALSE(opens([](SurfaceHeader& h) { h.solids_share = std::nan(""); }));
  EXPECT_FALSE(opens([](SurfaceHeader& h) { h.solids_share = 1.5; }));
  EXPECT_FALSE(opens([](SurfaceHeader& h) { h.version = SurfaceHeader::kOriginVersion, h.origin[0] = 1; }));
  EXPECT_FALSE(opens([](SurfaceHeader& h) { h.stored_solids[0].planes[2][3] = std::nan(""); }));
  EXPECT_FALSE(opens([](SurfaceHeader& h) { h.stored_solids[0].planes[2][0] = 0.5; })) << "no unit normal";
  EXPECT_FALSE(opens([](SurfaceHeader& h) { h.stored_solids[0].planes[5][2] = -1; })) << "unbounded";
  EXPECT_FALSE(opens([](SurfaceHeader& h) { h.stored_solids[0].planes[5][3] = -2000; })) << "beyond the surface";
  EXPECT_FALSE(opens([](SurfaceHeader& h) { h.stored_solids[0].planes[5][3] = 1; })) << "empty";
  EXPECT_FALSE(opens([](SurfaceHeader& h) {
    for (double& number : h.stored_solids[1].planes[3]) number = 0;
  })) << "a gap";
  EXPECT_FALSE(opens([](SurfaceHeader& h) { h.stored_solids[3].planes[0][0] = 1; })) << "more than it says";
}

TEST_F(SurfaceFile, IsToldFromATerrain) {
  EXPECT_TRUE(isSurfaceFile(path));
  EXPECT_FALSE(Scene::open(path).ok());
  EXPECT_FALSE(isSurfaceFile(folder / "missing.fls"));
  EXPECT_FALSE(isSurfaceFile(folder.path()));
}

TEST_F(SurfaceFile, CutShortAnywhereIsRefused) {
  for (size_t size = 0; size < bytes.size(); size += 1 + size / 40) {
    test::spit(folder / "cut.fls", {bytes.begin(), bytes.begin() + static_cast<ptrdiff_t>(size)});
    const auto surface = MappedSurface::open(folder / "cut.fls");
    ASSERT_FALSE(surface.ok()) << size;
    EXPECT_NE(surface.error().message.find("cut.fls"), std::string::npos);
  }
}

TEST_F(SurfaceFile, AnyFlippedByteIsRefusedOrFound) {
  constexpr uint64_t kSeed = 3;
  SCOPED_TRACE(kSeed);
  Rng rng(kSeed);
  for (int i = 0; i < 3000; ++i) {
    const size_t at = i < 400 ? static_cast<size_t>(i) : rng.below(bytes.size());
    auto damaged = bytes;
    damaged[at] = static_cast<char>(damaged[at] ^ (1 << rng.below(8)));
    test::spit(folder / "flip.fls", damaged);
    if (const auto surface = MappedSurface::open(folder / "flip.fls"); surface.ok()) touch(**surface);
    const auto found = verifySurface(folder / "flip.fls", 1);
    EXPECT_TRUE(!found.ok() || !found->sound()) << "byte " << at;
  }
}

// Damage that a checksum cannot see: the header is made to agree with itself again.
TEST_F(SurfaceFile, ForgedHeadersAndBasesAreRefusedOrHarmless) {
  constexpr uint64_t kSeed = 4;
  SCOPED_TRACE(kSeed);
  Rng rng(kSeed);
  SurfaceHeader original;
  std::memcpy(&original, bytes.data(), sizeof(original));
  const auto& ranges = original.sections;
  int opened = 0, refused = 0;
  for (int i = 0; i < 3000; ++i) {
    auto forged = bytes;
    const size_t at = i % 3 == 0 ? ranges[kSurfaceFaces].offset + rng.below(ranges[kSurfaceFaces].bytes)
                                 : 16 + rng.below(sizeof(SurfaceHeader) - 16);
    forged[at] = static_cast<char>(rng.below(4) == 0 ? rng.below(256) : forged[at] ^ (1 << rng.below(8)));
    SurfaceHeader header;
    std::memcpy(&header, forged.data(), sizeof(header));
    header.scene_id =
        contentId(header, {reinterpret_cast<const uint8_t*>(forged.data()) + ranges[kSurfaceChecksums].offset,
                           ranges[kSurfaceChecksums].bytes});
    header.header_checksum = headerChecksum(header);
    std::memcpy(forged.data(), &header, sizeof(header));
    test::spit(folder / "forged.fls", forged);
    const auto surface = MappedSurface::open(folder / "forged.fls");
    if (surface.ok()) touch(**surface);
    (surface.ok() ? opened : refused) += 1;
  }
  EXPECT_GT(opened, 0);
  EXPECT_GT(refused, 100);
}

TEST_F(SurfaceFile, VerifyNamesPaddingThatIsNotZeroAndBoundsThatDoNotHold) {
  Made made = makeContent(test::torusBase(3, 3), proto::MeshRule::kQuadrisection, 2);
  const proto::MeshTopology& topology = made.surface.topology;
  const auto faults = [&] {
    EXPECT_TRUE(writeSurface(path, made.content()).ok());
    const auto found = verifySurface(path);
    EXPECT_TRUE(found.ok());
    std::string all;
    for (const std::string& fault : found->first_faults) all += fault + '\n';
    return all;
  };
  proto::Slot padding = 0;
  while (!topology.isBase(topology.node(padding))) ++padding;
  made.records[padding].bulge.root = 1;
  EXPECT_EQ(faults(), "slot " + std::to_string(padding) + " is padding but not zero\n");
  made.records[padding] = {};
  const proto::SurfaceRecord whole = made.records[0];
  made.records[0].radius.bits = static_cast<uint16_t>(whole.radius.bits / 2);
  EXPECT_NE(faults().find("slot 0 has a sphere that does not hold"), std::string::npos);
  made.records[0] = whole, made.records[0].error_along = made.records[0].error_across = {};
  EXPECT_NE(faults().find("slot 0 has an error shape that does not hold that of its child"), std::string::npos);
  made.records[0] = whole, made.records[0].cone_sine = {};
  EXPECT_NE(faults().find("slot 0 has a cone of normals that does not hold that of its child"), std::string::npos);
  made.records[0] = whole, made.records[0].radius.bits = 0xffff;
  EXPECT_NE(faults().find("slot 0 has a bound that is no number"), std::string::npos);
  made.records[0] = whole, made.texels[3] ^= 1;
  EXPECT_EQ(faults(), "pixel (3, 0) of the image is not what base face 0 must have there\n");
}

}  // namespace
}  // namespace foreland::terrain
