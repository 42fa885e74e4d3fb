// Messages: what goes in comes out, and any other bytes end in an Error.
#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "base/rng.h"
#include "proto/message/message.h"

namespace foreland::proto {
namespace {

Pose somePose(Rng& rng) {
  glm::dquat q(rng.uniform(-1, 1), rng.uniform(-1, 1), rng.uniform(-1, 1), rng.uniform(-1, 1));
  return {{rng.uniform(-1e6, 1e6), rng.uniform(-1e6, 1e6), rng.uniform(-1e4, 1e4)}, glm::normalize(q)};
}

double angleBetween(const glm::dquat& a, const glm::dquat& b) {
  return 2 * std::acos(std::min(1.0, std::fabs(glm::dot(a, b))));
}

TEST(Message, PosesArriveToTheMillimetreAndToATenthOfAMilliradian) {
  Rng rng(3);
  for (int i = 0; i < 1000; ++i) {
    PoseUpdate sent{
        {Time{static_cast<int64_t>(rng.below(1ull << 40))}, somePose(rng)}, static_cast<uint32_t>(rng.below(9000)), {}};
    sent.received_at = sent.pose.time - Duration{static_cast<int64_t>(rng.below(1'000'000))};
    auto message = decodeClientMessage(encode(sent));
    ASSERT_TRUE(message.ok()) << message.error().message;
    const auto& got = std::get<PoseUpdate>(*message);
    EXPECT_EQ(got.pose.time, sent.pose.time);
    EXPECT_EQ(got.received_keyframe, sent.received_keyframe);
    EXPECT_EQ(got.received_at, sent.received_at);
    EXPECT_LE(glm::distance(got.pose.pose.eye, sent.pose.pose.eye), 0.001);
    EXPECT_LE(angleBetween(got.pose.pose.orientation, sent.pose.pose.orientation), 1e-4);
  }
}

TEST(Message, APoseAsSentIsSentUnchanged) {
  Rng rng(4);
  for (int i = 0; i < 1000; ++i) {
    KeyframeHeader header{2, 1, Time{5}, somePose(rng), {}, 1, 0, 0, 99};
    Bytes bytes;
    encodeHeader(header, bytes);
    auto message = decodeServerMessage(bytes);
    ASSERT_TRUE(message.ok());
    const Pose& got = std::get<KeyframeMessage>(*message).header.pose;
    EXPECT_EQ(got.eye, asSentInHeader(header.pose).eye);
    EXPECT_EQ(got.orientation, asSentInHeader(header.pose).orientation);
  }
}

TEST(Message, ALongestIntervalThatIsNoneIsRefused) {
  const auto asking = [](int64_t shortest_ms, int64_t longest_ms) {
    return encode(ViewRequest{.lens = {0.9, 800, 600},
                              .keyframe_interval = Duration::milliseconds(shortest_ms),
                              .longest_interval = Duration::milliseconds(longest_ms)});
  };
  EXPECT_TRUE(decodeClientMessage(asking(200, 200)).ok());
  EXPECT_TRUE(decodeClientMessage(asking(20, 10'000)).ok());
  for (const Bytes& bytes : {asking(0, 200), asking(200, 199), asking(200, 10'001)}) {
    const auto message = decodeClientMessage(bytes);
    ASSERT_FALSE(message.ok());
    EXPECT_NE(message.error().message.find("longest keyframe interval"), std::string::npos);
  }
}

TEST(Message, AnOrderIsOneToThreeAndAboveOneOfAFixedInterval) {
  const auto asking = [](uint32_t order, int64_t longest_ms) {
    return decodeClientMessage(encode(ViewRequest{.lens = {0.9, 800, 600},
                                                  .keyframe_interval = Duration::milliseconds(200),
                                                  .longest_interval = Duration::milliseconds(longest_ms),
                                                  .order = order}));
  };
  for (uint32_t order = 1; order <= kMaxOrder; ++order) {
    ASSERT_TRUE(asking(order, 0).ok());
    EXPECT_EQ(std::get<ViewRequest>(*asking(order, 0)).order, order);
  }
  EXPECT_TRUE(asking(1, 500).ok());
  for (const auto& refused : {asking(kMaxOrder + 1, 0), asking(2, 500)}) {
    ASSERT_FALSE(refused.ok());
    EXPECT_NE(refused.error().message.find("order"), std::string::npos);
  }
}

TEST(Message, EyesAreUpToAHundredMetresFromThePose) {
  const auto asking = [](double radius_m) {
    ViewRequest request;
    request.lens = {0.9, 800, 600};
    request.eye_radius_m = radius_m;
    return decodeClientMessage(encode(request));
  };
  for (const double radius_m : {0.0, 0.032, kMaxEyeRadius_m}) {
    ASSERT_TRUE(asking(radius_m).ok());
    EXPECT_EQ(std::get<ViewRequest>(*asking(radius_m)).eye_radius_m, radius_m);
  }
  for (const double radius_m : {-1e-3, 100.1, std::numeric_limits<double>::infinity(), std::nan("")}) {
    ASSERT_FALSE(asking(radius_m).ok()) << radius_m;
    EXPECT_NE(asking(radius_m).error().message.find("eyes"), std::string::npos);
  }
}

TEST(Message, ControlMessagesRoundTrip) {
  const ViewRequest request{
      {0.9, 800, 600}, 1.5, Strategy::kCurrent, Predictor::kKnownPath, Duration::milliseconds(250)};
  const auto got_request = std::get<ViewRequest>(*decodeClientMessage(encode(request)));
  EXPECT_EQ(got_request.lens, request.lens);
  EXPECT_EQ(got_request.tau_px, request.tau_px);
  EXPECT_EQ(got_request.strategy, request.strategy);
  EXPECT_EQ(got_request.predictor, request.predictor);
  EXPECT_EQ(got_request.keyframe_interval, request.keyframe_interval);
  EXPECT_EQ(got_request.longest_interval, Duration{});
  const ViewRequest adaptive{.lens = {0.9, 800, 600},
                             .keyframe_interval = Duration::milliseconds(250),
                             .longest_interval = Duration::milliseconds(750)};
  EXPECT_EQ(std::get<ViewRequest>(*decodeClientMessage(encode(adaptive))).longest_interval, adaptive.longest_interval);

  Rng rng(5);
  const Path path{Time{-7}, Duration::milliseconds(100), {somePose(rng), somePose(rng), somePose(rng)}};
  const auto got_path = std::get<Path>(*decodeClientMessage(encode(path)));
  EXPECT_EQ(got_path.start, path.start);
  EXPECT_EQ(got_path.step, path.step);
  ASSERT_EQ(got_path.poses.size(), 3u);
  EXPECT_EQ(got_path.poses[1].eye, path.poses[1].eye);

  const auto got_tour = std::get<TourRequest>(*decodeClientMessage(encode(TourRequest{4, "canyon", 30})));
  EXPECT_EQ(got_tour.name, "canyon");
  const auto got_ground = std::get<GroundRequest>(*decodeClientMessage(encode(GroundRequest{4, {{1, 2}, {3, 4}}})));
  EXPECT_EQ(got_ground.positions, (std::vector<glm::dvec2>{{1, 2}, {3, 4}}));
  EXPECT_EQ(std::get<GroundReply>(*decodeServerMessage(encode(GroundReply{4, {1.5f}, {}}))).heights_m,
            std::vector<float>{1.5f});
  EXPECT_EQ(std::get<Refusal>(*decodeServerMessage(encode(Refusal{"no"}))).message, "no");
}

TEST(Message, WhatIsAskedAndToldOfWhatIsSeenComesBack) {
  const SightRequest pairs{5, {{1, 2, 3}, {-4, 5, -6}}, Above::kZeroSurface, 0.25, Time{77}};
  const auto got_pairs = std::get<SightRequest>(*decodeClientMessage(encode(pairs)));
  EXPECT_EQ(got_pairs.id, 5u);
  EXPECT_EQ(got_pairs.ends, pairs.ends);
  EXPECT_EQ(got_pairs.above, Above::kZeroSurface);
  EXPECT_EQ(got_pairs.refraction, 0.25);
  EXPECT_EQ(got_pairs.scene_time, Time{77});
  const ViewshedRequest asked{6, {1.5, 2.5}, 3, 4, 5, 6, 0.5, Time{-8}};
  const auto got_asked = std::get<ViewshedRequest>(*decodeClientMessage(encode(asked)));
  EXPECT_EQ(got_asked.observer, asked.observer);
  EXPECT_EQ((std::array{got_asked.observer_m, got_asked.target_m, got_asked.radius_m, got_asked.cell_m}),
            (std::array<double, 4>{3, 4, 5, 6}));
  EXPECT_EQ(got_asked.scene_time, Time{-8});
  EXPECT_EQ(std::get<RequestCancel>(*decodeClientMessage(encode(RequestCancel{9}))).id, 9u);

  const SightReply told{5, "", {{1, 2, 3}, {4, 5, 6}}, {{{7, 8, 9}, SightHit::kGround}}};
  const auto got_told = std::get<SightReply>(*decodeServerMessage(encode(told)));
  EXPECT_EQ(got_told.ends, told.ends);
  ASSERT_EQ(got_told.hits.size(), 1u);
  EXPECT_EQ(got_told.hits[0].position, told.hits[0].position);
  EXPECT_EQ(got_told.hits[0].what, SightHit::kGround);
  for (uint32_t count = 0; count < 9; ++count) {
    ViewshedReply cells{6, "", {1, 2}, {3, 4}, 5, 3, 2, {}};
    for (uint32_t i = 0; i < count; ++i) cells.cells.push_back(static_cast<ViewshedCell>(i % 3));
    const auto got = std::get<ViewshedReply>(*decodeServerMessage(encode(cells)));
    EXPECT_EQ(got.cells, cells.cells);
    EXPECT_EQ((std::array{got.columns, got.rows, got.begin}), (std::array<uint32_t, 3>{5, 3, 2}));
    EXPECT_EQ(got.first, cells.first);
    EXPECT_EQ(got.step, cells.step);
  }
  ViewshedReply none;
  none.error = "why";
  EXPECT_EQ(std::get<ViewshedReply>(*decodeServerMessage(encode(none))).error, "why");
}

TEST(Message, WhatIsAskedOfWhatIsSeenIsHeldToItsBounds) {
  const double kNaN = std::nan(""), kBad[] = {kNaN, HUGE_VAL, -HUGE_VAL, 1e300, -1e300};
  const auto isTaken = [](const auto& message) { return decodeClientMessage(encode(message)).ok(); };
  const SightRequest pairs{1, {{1, 2, 3}, {4, 5, 6}}};
  ASSERT_TRUE(isTaken(pairs));
  for (const double bad : kBad) {
    for (int axis = 0; axis < 3; ++axis) {
      SightRequest request = pairs;
      request.ends[1][axis] = bad;
      EXPECT_FALSE(isTaken(request)) << bad;
    }
    SightRequest request = pairs;
    request.refraction = bad;
    EXPECT_FALSE(isTaken(request)) << bad;
  }
  EXPECT_FALSE(isTaken(SightRequest{1, {}}));
  EXPECT_FALSE(isTaken(SightRequest{1, {{1, 2, 3}}}));
  EXPECT_TRUE(isTaken(SightRequest{1, std::vector<glm::dvec3>(2 * kMaxSightPairs)}));
  EXPECT_FALSE(isTaken(SightRequest{1, std::vector<glm::dvec3>(2 * kMaxSightPairs + 2)}));
  EXPECT_FALSE(isTaken(SightRequest{1, {{}, {}}, static_cast<Above>(2)}));
  EXPECT_FALSE(isTaken(SightRequest{1, {{}, {}}, Above::kGround, 0, Time{INT64_MAX}}));

  ASSERT_TRUE(isTaken(ViewshedRequest{}));
  for (double ViewshedRequest::*field :
       {&ViewshedRequest::observer_m, &ViewshedRequest::target_m, &ViewshedRequest::radius_m, &ViewshedRequest::cell_m,
        &ViewshedRequest::refraction})
    for (const double bad : {kNaN, HUGE_VAL, 1e300, -1.0}) {
      ViewshedRequest request;
      request.*field = bad;
      EXPECT_FALSE(isTaken(request)) << bad;
    }
  ViewshedRequest request;
  request.cell_m = 0;
  EXPECT_FALSE(isTaken(request));
  request = {};
  request.observer.y = kNaN;
  EXPECT_FALSE(isTaken(request));
}

TEST(Message, AViewshedOfMoreCellsThanItHasIsRefused) {
  const auto isTaken = [](uint32_t columns, uint32_t rows, uint32_t begin, size_t cells) {
    const ViewshedReply reply{1, "", {0, 0}, {1, 1}, columns, rows, begin, std::vector<ViewshedCell>(cells)};
    return decodeServerMessage(encode(reply)).ok();
  };
  EXPECT_TRUE(isTaken(10, 10, 90, 10));
  EXPECT_FALSE(isTaken(10, 10, 91, 10));
  EXPECT_FALSE(isTaken(10, 10, 0xffffffff, 10));
  EXPECT_FALSE(isTaken(65536, 65536, 0, 10));
  EXPECT_FALSE(isTaken(2048, 2049, 0, 10));
  EXPECT_FALSE(isTaken(2048, 2048, 0, kMaxCellsTold + 1));
}

TEST(Message, AWelcomeTellsAsManyModelsAndObjectsAsASceneHolds) {
  Welcome sent;
  sent.shape = {1, 1, 1, 2, 2};
  sent.frame.axis_x_m = {1, 0};
  sent.frame.axis_y_m = {0, 1};
  sent.keyframe_interval = Duration::milliseconds(200);
  sent.corner_heights.resize(4);
  sent.centre_heights.resize(1);
  ObjectModel model;
  model.shape.vertex_count = 3;
  model.shape.faces.push_back({0, 1, 2});
  model.base = {{0, 0, 0}, {4, 0, 0}, {0, -4, 2}};
  model.atlas_side = 7;
  sent.models.resize(ObjectSet::kMaxModels, model);
  Rng rng(6);
  for (uint32_t i = 0; i < ObjectSet::kMaxObjects; ++i) {
    const Pose pose = somePose(rng);
    sent.objects.push_back({i % 1024, pose.eye, pose.orientation, 0.5 + i});
  }
  const auto message = decodeServerMessage(encode(sent));
  ASSERT_TRUE(message.ok()) << message.error().message;
  const auto& got = std::get<Welcome>(*message);
  EXPECT_TRUE(got.models == sent.models);
  ASSERT_EQ(got.objects.size(), sent.objects.size());
  for (size_t i = 0; i < got.objects.size(); ++i) {
    EXPECT_EQ(got.objects[i].model, sent.objects[i].model);
    EXPECT_EQ(got.objects[i].position, sent.objects[i].position);
    EXPECT_EQ(got.objects[i].orientation, sent.objects[i].orientation);
    EXPECT_EQ(got.objects[i].scale, sent.objects[i].scale);
  }
  sent.models.push_back(sent.models.front());
  EXPECT_FALSE(decodeServerMessage(encode(sent)).ok());
}

// Of a scene that changes in time, with three objects of one model.
Welcome movingWelcome() {
  Welcome sent;
  sent.shape = {1, 1, 1, 3, 3};
  sent.frame.axis_x_m = {1, 0};
  sent.frame.axis_y_m = {0, 1};
  sent.keyframe_interval = Duration::milliseconds(200);
  sent.corner_heights.resize(4);
  sent.centre_heights.resize(1);
  sent.models.resize(1);
  sent.models[0].shape.vertex_count = 3;
  sent.models[0].shape.faces.push_back({0, 1, 2});
  sent.models[0].base = {{0, 0, 0}, {4, 0, 0}, {0, -4, 2}};
  for (int64_t t : {0, 5, 9}) sent.epochs.push_back({Time{t}, t == 0 ? LatticeWindow{} : LatticeWindow{0, 0, 3, 3}});
  sent.objects.resize(3);
  return sent;
}

TEST(Message, AWelcomeTellsThePosesOfModels) {
  Welcome sent = movingWelcome();
  sent.models.push_back(sent.models[0]);
  ObjectModel& posed = sent.models[1];
  posed.pose_epochs = {0, 2};
  posed.base_moves = {{1, 2, -3}, {0, 0, 0}, {kMaxObjectQuanta, 0, 7}};
  sent.objects[1].model = 1;
  const auto message = decodeServerMessage(encode(sent));
  ASSERT_TRUE(message.ok()) << message.error().message;
  EXPECT_EQ(std::get<Welcome>(*message).models, sent.models);
  const auto isRefused = [&](const auto& spoil) {
    Welcome wrong = sent;
    spoil(wrong);
    return !decodeServerMessage(encode(wrong)).ok();
  };
  EXPECT_TRUE(isRefused([](Welcome& w) { w.models[1].pose_epochs = {0, 3}; })) << "no such epoch";
  EXPECT_TRUE(isRefused([](Welcome& w) { w.models[1].pose_epochs = {2, 0}; })) << "out of order";
  EXPECT_TRUE(isRefused([](Welcome& w) { w.models[1].pose_epochs = {1, 1}; })) << "twice";
  EXPECT_TRUE(isRefused([](Welcome& w) { w.models[1].pose_epochs = {0, 1, 2}; })) << "too few moves";
  EXPECT_TRUE(isRefused([](Welcome& w) { w.models[1].base_moves.pop_back(); }));
  EXPECT_TRUE(isRefused([](Welcome& w) { w.models[1].base_moves[0] = glm::ivec3(-kMaxObjectQuanta - 1); }));
  EXPECT_TRUE(isRefused([](Welcome& w) { w.epoch_blend = EpochBlend::kCatmullRom; })) << "which overshoots";
  EXPECT_TRUE(isRefused([](Welcome& w) { w.epochs.clear(); }));
}

// A globe's shape is a cube's, and its frame knows the cube: neither is said twice.
TEST(Message, AWelcomeTellsOfAGlobe) {
  Welcome sent;
  sent.shape = GridTopology::cubeShape(7, 5);
  sent.frame.kind = FrameKind::kGlobe;
  sent.frame.face_steps = 1u << 7;
  sent.frame.origin.height_m = -11'000;
  sent.corner_heights.assign(14, 3);
  sent.centre_heights.assign(6, 4);
  sent.tau_px = 1;
  sent.keyframe_interval = Duration::milliseconds(100);
  const auto message = decodeServerMessage(encode(sent));
  ASSERT_TRUE(message.ok()) << message.error().message;
  EXPECT_EQ(std::get<Welcome>(*message).shape, sent.shape);
  EXPECT_EQ(std::get<Welcome>(*message).frame, sent.frame);
  const auto isRefused = [&](const auto& spoil) {
    Welcome wrong = sent;
    spoil(wrong);
    return !decodeServerMessage(encode(wrong)).ok();
  };
  EXPECT_TRUE(isRefused([](Welcome& w) { w.shape.roots_y = 2; }));
  EXPECT_TRUE(isRefused([](Welcome& w) { w.shape.samples_x -= 1; }));
  EXPECT_TRUE(isRefused([](Welcome& w) { w.frame.origin.height_m = -1e6; }));
  EXPECT_TRUE(isRefused([](Welcome& w) { w.frame.flattening = 0.2; }));
  EXPECT_TRUE(isRefused([](Welcome& w) { w.corner_heights.pop_back(); }));
}

TEST(Message, AWelcomeTellsHowObjectsRise) {
  Welcome sent = movingWelcome();
  sent.epoch_blend = EpochBlend::kCatmullRom;
  const Epochs epochs = Epochs::create(sent.shape, sent.epochs, sent.epoch_blend).value();
  sent.objects[0].rise = GroundRise({0, -20, 7}, epochs, sent.frame, {});
  sent.objects[2].rise = GroundRise({0, 0, kMaxOffset}, epochs, sent.frame, {});
  const auto message = decodeServerMessage(encode(sent));
  ASSERT_TRUE(message.ok()) << message.error().message;
  EXPECT_EQ(std::get<Welcome>(*message).epoch_blend, sent.epoch_blend);
  for (size_t i = 0; i < 3; ++i) EXPECT_EQ(std::get<Welcome>(*message).objects[i].rise, sent.objects[i].rise);
  Welcome unknown = sent;
  unknown.epoch_blend = static_cast<EpochBlend>(3);
  const auto refused = decodeServerMessage(encode(unknown));
  ASSERT_FALSE(refused.ok());
  EXPECT_NE(refused.error().message.find("blended in an unknown way"), std::string::npos);
  for (const std::vector<int32_t>& absurd : {std::vector<int32_t>{0, 0, kMaxOffset + 1}, {0, 0, 0, 1}}) {
    Welcome wrong = sent;
    wrong.objects[1].rise.quanta = absurd;
    EXPECT_FALSE(decodeServerMessage(encode(wrong)).ok());
  }
}

TEST(Message, AbsurdValuesAreRefused) {
  for (double tau : {-1.0, 1e-9, 1e9, std::nan("")}) {
    ViewRequest request;
    request.tau_px = tau;
    EXPECT_FALSE(decodeClientMessage(encode(request)).ok()) << tau;
  }
  const auto throughLens = [](const Lens& lens) {
    ViewRequest request;
    request.lens = lens;
    return decodeClientMessage(encode(request));
  };
  for (const Lens& absurd : {Lens{1, 16385, 600}, Lens{1, 0, 16385}, Lens{0, 0, 0}, Lens{3, 800, 600}})
    EXPECT_FALSE(throughLens(absurd).ok());
  for (const Lens& closed : {Lens{1, 0, 0}, Lens{1, 800, 0}, Lens{1, 0, 600}}) {
    const auto request = throughLens(closed);
    ASSERT_TRUE(request.ok()) << request.error().message;
    EXPECT_EQ(std::get<ViewRequest>(*request).lens, closed);
    EXPECT_TRUE(std::get<ViewRequest>(*request).showsNothing());
  }
  for (double bad : {std::nan(""), HUGE_VAL, 1e9}) {
    Path path{{}, Duration::milliseconds(100), {{}, {}}};
    path.poses[1].eye.x = bad;
    EXPECT_FALSE(decodeClientMessage(encode(path)).ok()) << bad;
  }
  PoseUpdate far{{{}, {{2e8, 0, 0}, {1, 0, 0, 0}}}, 0, {}};
  EXPECT_FALSE(decodeClientMessage(encode(far)).ok());
}

TEST(Message, AnyBytesEndInAValueOrAnError) {
  const uint64_t seed = testing::UnitTest::GetInstance()->random_seed();
  Rng rng(seed);
  const std::vector<Bytes> good{encode(ViewRequest{}),
                                encode(TourRequest{1, "spin", 9}),
                                encode(GroundRequest{1, {{1, 2}}}),
                                encode(PoseUpdate{}),
                                encode(Refusal{"x"}),
                                encode(GroundReply{1, {2}, {50}}),
                                encode(SightRequest{1, {{1, 2, 3}, {4, 5, 6}}}),
                                encode(ViewshedRequest{}),
                                encode(RequestCancel{1}),
                                encode(SightReply{1, "", {{}, {}}, {{}}}),
                                encode(ViewshedReply{1, "", {}, {}, 2, 2, 0, std::vector<ViewshedCell>(4)})};
  size_t accepted = 0;
  for (int i = 0; i < 20000; ++i) {
    Bytes bytes = good[rng.below(good.size())];
    for (uint64_t k = rng.below(4) + 1; k > 0; --k) bytes[rng.below(bytes.size())] = static_cast<uint8_t>(rng.next());
    if (rng.below(3) == 0) bytes.resize(rng.below(bytes.size() + 1));
    accepted += decodeClientMessage(bytes).ok();
    accepted += decodeServerMessage(bytes).ok();
  }
  EXPECT_LT(accepted, 40000u) << "seed " << seed;
}

}  // namespace
}  // namespace foreland::proto
