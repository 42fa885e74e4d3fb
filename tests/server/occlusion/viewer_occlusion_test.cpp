// Along a flight, whatever a viewer's server calls hidden at a keyframe is hidden from the keyframe's whole region,
// however long ago it was found out; and most of it is not found out anew.
#include "server/occlusion/viewer_occlusion.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <bit>
#include <thread>

#include "tests/support/height_field.h"
#include "tests/support/scene.h"
#include "tests/support/wanderer.h"

namespace foreland::server {
namespace {

using proto::BlockId;

constexpr uint32_t kSide = BlockId::kSide;

Time at(int keyframe) { return Time::seconds(1) + Duration::milliseconds(200) * keyframe; }

// Asks for all blocks of a scale, and keeps what it is told, as a stream does.
class Watcher {
 public:
  explicit Watcher(uint32_t blocks) : tiles_(blocks / 4), hidden_(size_t{tiles_} * tiles_, -1) {}

  void see(ViewerOcclusion& viewer) {
    for (uint32_t y = 0; y < tiles_; ++y)
      for (uint32_t x = 0; x < tiles_; ++x) {
        int32_t& hidden = hidden_[size_t{y} * tiles_ + x];
        if (hidden >= 0) {
          hidden ^= static_cast<int32_t>(viewer.changes({0, 4 * x, 4 * y}, 0xffff, static_cast<uint32_t>(hidden)));
          continue;
        }
        hidden = 0;
        for (uint32_t bit = 0; bit < 16; ++bit)
          hidden |= (viewer.isHidden({0, 4 * x + bit % 4, 4 * y + bit / 4}) ? 1 : 0) << bit;
      }
  }
  bool isHidden(uint32_t x, uint32_t y) const {
    return (hidden_[size_t{y / 4} * tiles_ + x / 4] >> (y % 4 * 4 + x % 4) & 1) != 0;
  }
  const std::vector<int32_t>& all() const { return hidden_; }

 private:
  uint32_t tiles_;
  std::vector<int32_t> hidden_;  // by tile; -1: not asked for
};

// Flies a winding way over a scene, the path of which is known, or guessed with an error.
class Flight {
 public:
  Flight(proto::FrameKind kind, double error_m, double speed = 0.4)
      : scene_(test::makeScene(257, 257, 7, kind)), error_m_(error_m), speed_(speed) {
    for (int keyframe = -1; keyframe <= kKeyframes + 40; ++keyframe) path_.poses.push_back(viewOf(keyframe).pose);
  }
  static constexpr int kKeyframes = 60;

  const Hierarchy& hierarchy() const { return hierarchy_; }
  const foreland::test::HeightField& field() const { return field_; }
  const proto::Path& path() const { return path_; }
  glm::dvec2 at(int keyframe) const { return {40 + speed_ * keyframe, 128 + 25 * speed_ * std::sin(0.05 * keyframe)}; }
  proto::View viewOf(int keyframe) const {
    const glm::dvec2 p = at(keyframe);
    proto::View view = test::viewAt(hierarchy_, p.x, p.y, field_.at(p.x, p.y) + 60, 0, 0);
    view.tau_px = keyframe < 40 ? 1 : 1.1;
    view.region_radius_m = 5;
    return view;
  }
  // `clock` is the number of the interval at which the client's clock began.
  void begin(ViewerOcclusion& viewer, int keyframe, int64_t clock = 0) const {
    expect(viewer, keyframe, clock);
    viewer.begin(viewOf(keyframe));
  }
  void expect(ViewerOcclusion& viewer, int keyframe, int64_t clock = 0) const {
    const Duration interval = server::at(1) - server::at(0);
    PredictedEyePath eye_path =
        eyePathOf(ExpectedMotion(path_), server::at(keyframe - 1), server::at(keyframe + 1), interval, error_m_);
    // A guess is off by up to its error, another way each time.
    for (EyeCapsule& eyes : eye_path.eyes) eyes.eye.y += error_m_ * std::sin(2.5 * keyframe);
    // Nor does it always go far.
    if (error_m_ > 0) eye_path.eyes.resize(2 + static_cast<size_t>(keyframe) % 9);
    eye_path.first += clock;
    eye_path.last += clock;
    viewer.expect(eye_path);
  }

 private:
  std::shared_ptr<const terrain::Scene> scene_;
  Hierarchy hierarchy_{scene_};
  foreland::test::HeightField field_{hierarchy_};
  double error_m_, speed_;
  proto::Path path_{server::at(-1), server::at(1) - server::at(0), {}};
};

enum class BehindRidge { kRays, kHorizons };

SceneOcclusion occlusionOf(const Hierarchy& hierarchy, BehindRidge behind) {
  SceneOcclusion scene{BlockTops(hierarchy), nullptr, nullptr};
  if (behind == BehindRidge::kHorizons) scene.grid = HorizonGrid::of(hierarchy);
  if (behind == BehindRidge::kRays) scene.occluder = Occluder::create(hierarchy).value();
  return scene;
}

struct Guess {
  proto::FrameKind frame;
  BehindRidge behind;
  double error_m, speed;
};

class Viewer : public testing::TestWithParam<Guess> {};

TEST_P(Viewer, CallsHiddenWhatIsHiddenFromTheWholeRegion) {
  const auto seed = static_cast<uint64_t>(testing::UnitTest::GetInstance()->random_seed());
  SCOPED_TRACE(testing::Message() << "seed " << seed);
  Rng rng(seed);
  const Flight flight(GetParam().frame, GetParam().error_m, GetParam().speed);
  const SceneOcclusion shared = occlusionOf(flight.hierarchy(), GetParam().behind);
  ViewerOcclusion viewer(flight.hierarchy(), shared);
  Watcher watcher(256 / kSide);
  uint64_t hidden = 0, first_tests = 0;
  for (int keyframe = 0; keyframe < Flight::kKeyframes; ++keyframe) {
    flight.begin(viewer, keyframe);
    watcher.see(viewer);
    const glm::dvec2 eye_at = flight.at(keyframe);
    for (uint32_t j = 0; j < 256 / kSide; ++j)
      for (uint32_t i = 0; i < 256 / kSide; ++i) {
        if (!watcher.isHidden(i, j) || kSide * i < eye_at.x + 30 ||
            std::abs(kSide * (j + 0.5) - eye_at.y) > 0.3 * (kSide * i - eye_at.x))
          continue;
        ++hidden;
        const double sx = kSide * (i + rng.uniform()), sy = kSide * (j + rng.uniform());
        const glm::dvec3 point =
            flight.hierarchy().frame().transform().toScene(proto::LatticePosition{sx, sy, flight.field().at(sx, sy)});
        const auto share = Duration{static_cast<int64_t>(rng.below(400'000))};
        const glm::dvec3 eye = flight.path().at(at(keyframe - 1) + share).eye;
        EXPECT_FALSE(flight.field().isClear(eye, point, 0.5)) << "keyframe " << keyframe << " block " << i << " " << j;
      }
    if (keyframe == 0) first_tests = viewer.statistics().tests;
  }
  EXPECT_GT(hidden, 30u);
  if (GetParam().error_m == 0) {
    EXPECT_LT((viewer.statistics().tests - first_tests) / (Flight::kKeyframes - 1), first_tests / 3);
  }
}

INSTANTIATE_TEST_SUITE_P(Guesses, Viewer,
                         testing::Values(Guess{proto::FrameKind::kPlanar, BehindRidge::kHorizons, 0, 0.4},
                                         Guess{proto::FrameKind::kPlanar, BehindRidge::kHorizons, 2, 0.4},
                                         Guess{proto::FrameKind::kGeographic, BehindRidge::kHorizons, 0, 0.02},
                                         Guess{proto::FrameKind::kGeographic, BehindRidge::kHorizons, 0.5, 0.02},
                                         Guess{proto::FrameKind::kGeographic, BehindRidge::kRays, 0, 0.02}));

uint64_t hiddenBlocks(const Watcher& watcher) {
  uint64_t hidden = 0;
  for (const int32_t tile : watcher.all()) hidden += static_cast<uint64_t>(std::popcount(static_cast<uint32_t>(tile)));
  return hidden;
}

// What fades turns visible a little in each keyframe, until nothing in view is hidden; and what is not yet is hidden
// indeed. After that as much is hidden again as if nothing had faded.
TEST(ViewerOcclusion, FadesPartByPartAndComesBack) {
  const auto seed = static_cast<uint64_t>(testing::UnitTest::GetInstance()->random_seed());
  SCOPED_TRACE(testing::Message() << "seed " << seed);
  Rng rng(seed);
  const Flight flight(proto::FrameKind::kPlanar, 0, 0.1);
  const auto shared = SceneOcclusion::create(flight.hierarchy()).value();
  ViewerOcclusion viewer(flight.hierarchy(), *shared);
  Watcher watcher(256 / kSide);
  constexpr int kBegin = 8, kEnd = kBegin + 12;
  uint64_t before = 0, at_first = 0, checked = 0;
  for (int keyframe = 0; keyframe < 40; ++keyframe) {
    viewer.setEffort(keyframe >= kBegin && keyframe < kEnd ? ViewerOcclusion::Effort::kFading
                                                           : ViewerOcclusion::Effort::kAll);
    flight.begin(viewer, keyframe);
    watcher.see(viewer);
    const uint64_t hidden = hiddenBlocks(watcher);
    if (keyframe == kBegin - 1) at_first = hidden;
    if (keyframe >= kBegin && keyframe < kEnd) {
      EXPECT_LE(hidden, before) << keyframe;
      EXPECT_LE(before - hidden, at_first / 4) << keyframe;
    }
    if (keyframe == kEnd - 1) { EXPECT_FALSE(viewer.hidesAnything()); }
    before = hidden;
    for (int i = 0; i < 2000; ++i) {
      const glm::dvec2 eye_at = flight.at(keyframe);
      const double x = rng.uniform(eye_at.x + 30, 255), y = rng.uniform(10, 250);
      if (!watcher.isHidden(static_cast<uint32_t>(x) / kSide, static_cast<uint32_t>(y) / kSide) ||
          std::abs(y - eye_at.y) > 0.3 * (x - eye_at.x))
        continue;
      ++checked;
      const glm::dvec3 point =
          flight.hierarchy().frame().transform().toScene(proto::LatticePosition{x, y, flight.field().at(x, y)});
      EXPECT_FALSE(flight.field().isClear(flight.viewOf(keyframe).pose.eye, point, 0.5)) << keyframe;
    }
  }
  EXPECT_GT(checked, 100u);
  EXPECT_GT(before, at_first / 2);
}

// A keyframe without time for first tests leaves nothing more out, and later ones do.
TEST(ViewerOcclusion, TestsLaterWhatThereWasNoTimeFor) {
  const Flight flight(proto::FrameKind::kPlanar, 0, 0.1);
  const auto shared = SceneOcclusion::create(flight.hierarchy()).value();
  ViewerOcclusion limited(flight.hierarchy(), *shared), free(flight.hierarchy(), *shared);
  Watcher seen(256 / kSide), all(256 / kSide);
  for (int keyframe = 0; keyframe < 30; ++keyframe) {
    limited.limitFirstTests(keyframe == 0 ? Duration{-1} : ViewerOcclusion::kUnlimited);
    for (auto [viewer, watcher] : {std::pair(&limited, &seen), {&free, &all}}) {
      flight.begin(*viewer, keyframe);
      watcher->see(*viewer);
    }
    if (keyframe == 0) { EXPECT_EQ(hiddenBlocks(seen), 0u); }
  }
  EXPECT_GT(hiddenBlocks(seen), hiddenBlocks(all) / 4) << "out of view none is tried again";
}

// A keyframe that is shown for many intervals: in a stall, or where a viewer's intervals are long and their least is
// short.
TEST(ViewerOcclusion, CallsHiddenWhatIsHiddenForAsLongAsAKeyframeIsShown) {
  const auto seed = static_cast<uint64_t>(testing::UnitTest::GetInstance()->random_seed());
  SCOPED_TRACE(testing::Message() << "seed " << seed);
  Rng rng(seed);
  const Flight flight(proto::FrameKind::kPlanar, 0);
  const auto shared = SceneOcclusion::create(flight.hierarchy()).value();
  const Duration interval = Duration::milliseconds(20);
  for (const int64_t shown : {1, 2, 19, 20, 21, 40, 41, 50, 99, 100, 101, 130, 250, 400}) {
    ViewerOcclusion viewer(flight.hierarchy(), *shared);
    Watcher watcher(256 / kSide);
    uint64_t hidden = 0;
    for (int keyframe = 0; keyframe < 4; ++keyframe) {
      const Time begin = at(0) + interval * (keyframe * std::max<int64_t>(1, shown / 2)),
                 end = begin + interval * shown;
      // What was expected at first was another way.
      PredictedEyePath eye_path = eyePathOf(ExpectedMotion(flight.path()), begin, end, interval, 0);
      if (keyframe == 0)
        for (EyeCapsule& eyes : eye_path.eyes) eyes.eye.z -= 30;
      proto::View view = flight.viewOf(0);
      view.pose.eye = eye_path.eyes.front().eye;
      viewer.expect(eye_path);
      viewer.begin(view);
      watcher.see(viewer);
      if (keyframe == 0) continue;
      for (uint32_t j = 0; j < 256 / kSide; ++j)
        for (uint32_t i = 0; i < 256 / kSide; ++i) {
          const glm::dvec2 eye_at = flight.at(0);
          if (!watcher.isHidden(i, j) || kSide * i < eye_at.x + 60 ||
              std::abs(kSide * (j + 0.5) - eye_at.y) > 0.3 * (kSide * i - eye_at.x))
            continue;
          ++hidden;
          const double sx = kSide * (i + rng.uniform()), sy = kSide * (j + rng.uniform());
          const glm::dvec3 point =
              flight.hierarchy().frame().transform().toScene(proto::LatticePosition{sx, sy, flight.field().at(sx, sy)});
          const Time when = begin + Duration{static_cast<int64_t>(rng.below(static_cast<uint64_t>((end - begin).us)))};
          EXPECT_FALSE(flight.field().isClear(flight.path().at(when).eye, point, 0.5))
              << shown << " intervals, keyframe " << keyframe << " block " << i << " " << j;
        }
    }
    EXPECT_GT(hidden, 30u) << shown;
  }
}

// The camera is expected to fly on at its height, but rises all of a sudden.
TEST(ViewerOcclusion, ForgetsProofsOfEyesThatAreElsewhere) {
  const auto seed = static_cast<uint64_t>(testing::UnitTest::GetInstance()->random_seed());
  SCOPED_TRACE(testing::Message() << "seed " << seed);
  Rng rng(seed);
  const Flight flight(proto::FrameKind::kPlanar, 0);
  const auto shared = SceneOcclusion::create(flight.hierarchy()).value();
  ViewerOcclusion viewer(flight.hierarchy(), *shared);
  Watcher watcher(256 / kSide);
  const auto countSeen = [&](const glm::dvec3& eye) {
    uint64_t seen = 0;
    for (int i = 0; i < 20000; ++i) {
      const double x = rng.uniform(80, 250), y = rng.uniform(10, 250);
      const glm::dvec3 point =
          flight.hierarchy().frame().transform().toScene(proto::LatticePosition{x, y, flight.field().at(x, y)});
      const bool is_hidden = watcher.isHidden(static_cast<uint32_t>(x) / kSide, static_cast<uint32_t>(y) / kSide);
      const glm::dvec3 way = point - eye;
      const bool is_in_view = std::abs(way.z) < 0.55 * way.x && std::abs(way.y) < 0.9 * way.x;
      seen += is_hidden && is_in_view && flight.field().isClear(eye, point, 0.5) ? 1 : 0;
    }
    return seen;
  };
  const glm::dvec3 rise(0, 0, 300);
  for (int keyframe = 0; keyframe < 6; ++keyframe) {
    proto::View view = flight.viewOf(0);
    PredictedEyePath eye_path{Duration::milliseconds(200), keyframe, keyframe + 1,
                              std::vector<EyeCapsule>(20, {view.pose.eye, {}, 1}), 0};
    for (EyeCapsule& eyes : eye_path.eyes) eyes.eye += keyframe < 3 ? glm::dvec3(0) : rise;
    view.pose.eye = eye_path.eyes[0].eye;
    viewer.expect(eye_path);
    viewer.begin(view);
    watcher.see(viewer);
    EXPECT_EQ(countSeen(view.pose.eye), 0u) << keyframe;
  }
}

// What one viewer is told depends on no other viewer, and on no thread.
TEST(Viewers, OfASceneAreToldTheSameOnTheirOwnAndTogether) {
  const Flight flight(proto::FrameKind::kPlanar, 0);
  const auto shared = SceneOcclusion::create(flight.hierarchy()).value();
  const auto fly = [&] {
    ViewerOcclusion viewer(flight.hierarchy(), *shared);
    Watcher watcher(256 / kSide);
    std::vector<std::vector<int32_t>> told;
    for (int keyframe = 0; keyframe < 20; ++keyframe) {
      flight.begin(viewer, keyframe);
      watcher.see(viewer);
      told.push_back(watcher.all());
    }
    return told;
  };
  const auto alone = fly();
  std::array<std::vector<std::vector<int32_t>>, 3> together;
  {
    std::vector<std::jthread> threads;
    for (auto& told : together) threads.emplace_back([&] { told = fly(); });
  }
  for (const auto& told : together) EXPECT_EQ(told, alone);
}

// Unix time in microseconds is 8.8e9 intervals of 200 ms.
TEST(ViewerOcclusion, TellsTheSameWhateverTheClientsClockSays) {
  const Flight flight(proto::FrameKind::kPlanar, 0);
  const auto shared = SceneOcclusion::create(flight.hierarchy()).value();
  const auto fly = [&](int64_t clock) {
    ViewerOcclusion viewer(flight.hierarchy(), *shared);
    Watcher watcher(256 / kSide);
    std::vector<std::vector<int32_t>> told;
    for (int keyframe = 0; keyframe < Flight::kKeyframes; ++keyframe) {
      flight.begin(viewer, keyframe, clock);
      watcher.see(viewer);
      told.push_back(watcher.all());
    }
    return std::pair(told, viewer.statistics().tests);
  };
  const auto plain = fly(0);
  constexpr int64_t kLongest = 16;  // of spans, which begin at multiples of their length
  for (const int64_t clock : {int64_t{1'764'000'000'000'000 / 200'000}, int64_t{1} << 31, -(int64_t{1} << 40)})
    EXPECT_EQ(fly(clock & -kLongest), plain) << clock;
}

// Memory stays what a few horizons and the proofs of the blocks that are known take, however long the flight.
TEST(ViewerOcclusion, KeepsNoMoreThanTheSceneAsksFor) {
  const Flight flight(proto::FrameKind::kPlanar, 1);
  const auto shared = SceneOcclusion::create(flight.hierarchy()).value();
  ViewerOcclusion viewer(flight.hierarchy(), *shared);
  Watcher watcher(256 / kSide);
  for (int keyframe = 0; keyframe < Flight::kKeyframes; ++keyframe) {
    flight.begin(viewer, keyframe);
    watcher.see(viewer);
    EXPECT_LT(viewer.bytes(), 8u << 20) << keyframe;
  }
}

// Looks all around with a lens of one degree, which makes bins of a thousandth of one.
proto::View narrowViewOf(const Flight& flight, int keyframe) {
  proto::View view = flight.viewOf(keyframe);
  const double turn = 0.4 * keyframe;
  view.pose.orientation = proto::lookAlong({std::cos(turn), std::sin(turn), -0.05}, {0, 0, 1});
  view.lens = {.vertical_fov_rad = 0.0175, .width_px = 16384, .height_px = 16384};
  return view;
}

TEST(ViewerOcclusion, KeepsNoMoreForANarrowLens) {
  const Flight flight(proto::FrameKind::kPlanar, 1);
  const auto shared = SceneOcclusion::create(flight.hierarchy()).value();
  ViewerOcclusion viewer(flight.hierarchy(), *shared);
  Watcher watcher(256 / kSide);
  for (int keyframe = 0; keyframe < 20; ++keyframe) {
    flight.expect(viewer, keyframe);
    viewer.begin(narrowViewOf(flight, keyframe));
    watcher.see(viewer);
    EXPECT_LT(viewer.bytes(), 4u << 20) << keyframe;
  }
}

// With less memory for horizons, more is done again and less is hidden, but nothing else is.
TEST(ViewerOcclusion, HidesOnlyWhatItHasMemoryToProve) {
  const Flight flight(proto::FrameKind::kPlanar, 0);
  const auto shared = SceneOcclusion::create(flight.hierarchy()).value();
  constexpr size_t kOneTest = 256 << 10;
  struct Seen {
    uint64_t hidden = 0, segments = 0;
    size_t max_bytes = 0;
  };
  const auto fly = [&](size_t horizon_bytes) {
    ViewerOcclusion viewer(flight.hierarchy(), *shared, {.rays = 0, .horizon_bytes = horizon_bytes});
    const size_t others = viewer.bytes();
    Watcher watcher(256 / kSide);
    Seen seen;
    for (int keyframe = 0; keyframe < 30; ++keyframe) {
      flight.begin(viewer, keyframe);
      watcher.see(viewer);
      for (const int32_t tile : watcher.all()) seen.hidden += static_cast<uint64_t>(std::popcount(uint32_t(tile)));
      seen.max_bytes = std::max(seen.max_bytes, viewer.bytes() - others);
    }
    seen.segments = viewer.statistics().segments;
    return seen;
  };
  const Seen all = fly(32 << 20), half = fly(all.max_bytes), little = fly(all.max_bytes / 4), none = fly(0);
  EXPECT_EQ(half.hidden, all.hidden);
  EXPECT_GT(half.segments, all.segments);
  EXPECT_GT(little.hidden, 0u);
  EXPECT_LT(little.hidden, all.hidden);
  EXPECT_LT(little.max_bytes, all.max_bytes / 4 + none.max_bytes + kOneTest);
  EXPECT_GT(all.max_bytes, all.max_bytes / 4 + none.max_bytes + kOneTest);
  EXPECT_EQ(none.hidden, 0u);
}

// Without an eye path the eye is taken to stay where it is.
TEST(ViewerOcclusion, NeedsNoEyePath) {
  const Flight flight(proto::FrameKind::kPlanar, 0);
  const auto shared = SceneOcclusion::create(flight.hierarchy()).value();
  ViewerOcclusion viewer(flight.hierarchy(), *shared);
  Watcher watcher(256 / kSide);
  viewer.begin(flight.viewOf(0));
  watcher.see(viewer);
  const uint64_t tests = viewer.statistics().tests;
  EXPECT_GT(std::count_if(watcher.all().begin(), watcher.all().end(), [](int32_t tile) { return tile != 0; }), 50);
  viewer.begin(flight.viewOf(0));
  watcher.see(viewer);
  EXPECT_LT(viewer.statistics().tests - tests, tests / 4);
}

}  // namespace
}  // namespace foreland::server
