// What a client reads of a surface is what the server has: the same records, the same sections, whatever the views.
#include <gtest/gtest.h>

#include "proto/surface_codec.h"
#include "terrain/surface/bounds.h"
#include "tests/support/surface_wanderer.h"
#include "tests/support/surfaces.h"

namespace foreland::proto {
namespace {

constexpr size_t kNoLimit = 1u << 30;

struct Ends {
  explicit Ends(const test::NamedSurface& named)
      : surface(named.surface),
        records(terrain::computeBounds(named.surface, {.threads = 1})),
        domain{.mesh = &named.surface.topology, .step_m = named.surface.step_m, .is_closed = named.is_closed},
        server(domain),
        client(domain) {}

  bool step(const View& view, CutDelta& sent, CutDelta& got) {
    Bytes bytes;
    RangeEncoder out(bytes);
    SurfaceEncoder encoder(domain, surface.base, records, server_model, out);
    EXPECT_TRUE(server.adapt(view, kNoLimit, encoder, scratch, sent));
    out.finish();
    bytes_sent += bytes.size();
    records_sent += encoder.sent();
    return read(view, bytes, got);
  }
  bool read(const View& view, ByteSpan bytes, CutDelta& got) {
    RangeDecoder in(bytes);
    SurfaceDecoder decoder(domain, surface.base, held, client_model, in);
    return client.adapt(view, kNoLimit, decoder, scratch, got) && !decoder.isBroken() && in.atEnd();
  }

  const terrain::TrueSurface& surface;
  std::vector<SurfaceRecord> records;
  SurfaceDomain domain;
  SurfaceAdapter server, client;
  SurfaceModel server_model, client_model;
  SurfaceRecords held;
  AdaptScratch scratch;
  uint64_t bytes_sent = 0, records_sent = 0;
};

class SurfaceCodec : public testing::TestWithParam<MeshRule> {};

TEST_P(SurfaceCodec, GivesTheClientTheServersSectionAndItsRecords) {
  const uint64_t seed = testing::UnitTest::GetInstance()->random_seed() + 1;
  RecordProperty("seed", std::to_string(seed));
  for (const test::NamedSurface& named : test::surfaces(GetParam(), GetParam() == MeshRule::kBisection ? 2 : 3)) {
    Ends ends(named);
    test::SurfaceWanderer wanderer(seed);
    for (int i = 0; i < 200; ++i) {
      const View view = wanderer.next();
      CutDelta sent, got;
      ASSERT_TRUE(ends.step(view, sent, got)) << named.name << ", seed " << seed << ", step " << i;
      ASSERT_EQ(got, sent) << named.name << ", seed " << seed << ", step " << i;
      for (const auto& [slot, a] : ends.held) {
        const SurfaceRecord& b = ends.records[slot];
        ASSERT_TRUE(a.position == b.position && a.radius == b.radius && a.error_along == b.error_along &&
                    a.error_across == b.error_across && a.cone_sine == b.cone_sine && a.bulge == b.bulge &&
                    a.normal == b.normal);
      }
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Rules, SurfaceCodec, testing::Values(MeshRule::kQuadrisection, MeshRule::kBisection));

TEST(SurfaceCodec, EndsInAClosedSectionOrARefusalWhateverTheBytes) {
  const uint64_t seed = testing::UnitTest::GetInstance()->random_seed() + 1;
  RecordProperty("seed", std::to_string(seed));
  Rng rng(seed);
  const test::NamedSurface sphere = test::surfaces(MeshRule::kQuadrisection, 4).front();
  uint32_t refused = 0;
  for (int round = 0; round < 200; ++round) {
    Ends ends(sphere);
    test::SurfaceWanderer wanderer(rng.below(1u << 30));
    for (int i = 0; i < 4; ++i) {
      Bytes bytes(rng.below(400));
      for (uint8_t& byte : bytes) byte = static_cast<uint8_t>(rng.below(256));
      CutDelta got;
      if (ends.read(wanderer.next(), bytes, got)) {
        ends.client.validate();
      } else {
        ++refused;
        break;
      }
    }
  }
  EXPECT_GT(refused, 100u);
}

}  // namespace
}  // namespace foreland::proto
