#include "tests/protocol/scripts.h"

#include <algorithm>
#include <cmath>

#include "proto/message/message.h"
#include "terrain/surface/bounds.h"
#include "tests/support/globe_scene.h"
#include "tests/support/scene.h"
#include "tests/support/sparse_scene.h"
#include "tests/support/surfaces.h"

namespace foreland::test {

namespace {

constexpr Duration at(double seconds) { return Duration::seconds(seconds); }

// A triangle wave between 0 and 1.
double zigzag(double x, double period) {
  const double u = x / period - std::floor(x / period);
  return u < 0.5 ? 2 * u : 2 - 2 * u;
}

// Slopes over several octaves, some noise, and a mesa with cliffs.
double country(uint32_t x, uint32_t y, double mesa_m) {
  double metres = Rng(static_cast<uint64_t>(y) << 32 | x).uniform(-1, 1);
  for (int octave = 0; octave < 5; ++octave) {
    const double size = 1.0 / (1 << octave);
    metres += 220 * size * zigzag(0.8 * x + 0.6 * y + 17 * octave, 90 * size);
    metres += 160 * size * zigzag(0.3 * x - 0.9 * y + 5 * octave, 130 * size);
  }
  return metres + (x > 90 && x < 110 && y > 40 && y < 75 ? mesa_m : 0);
}

std::shared_ptr<const server::World> worldOf(proto::FrameKind kind) {
  const bool planar = kind == proto::FrameKind::kPlanar;
  FormulaSource source(
      planar ? 180 : 150, planar ? 130 : 140,
      [planar](uint32_t x, uint32_t y) { return country(x, y, planar ? 170 : 60); }, kind);
  if (planar) {
    proto::Frame& frame = source.info().frame;
    frame.axis_x_m = {9.5, 2.5};
    frame.axis_y_m = {-2.25, 10};
  }
  source.info().title = planar ? "planar" : "geographic";
  return std::make_shared<server::World>(makeScene(source, planar ? 0.005 : 0.25));
}

// A smooth closed model refined by quadrisection, and a slightly rough one with borders refined by bisection.
struct Models {
  std::vector<terrain::TrueSurface> surfaces;
  std::vector<std::vector<proto::SurfaceRecord>> records;
  std::vector<std::vector<glm::ivec3>> moves;

  // With so many poses besides the first.
  explicit Models(size_t poses) {
    surfaces.push_back(*terrain::makeSphere(1, {proto::MeshRule::kQuadrisection, 4, 1e-6}));
    for (const NamedBase& b : baseMeshes())
      if (b.name == "ShuffledTube") surfaces.push_back(roughSurface(b, proto::MeshRule::kBisection, 3, 0.02, 7));
    for (terrain::TrueSurface& s : surfaces) {
      addPoses(s, poses, 0.3, 0.05, surfaces.size());
      records.push_back(terrain::computeBounds(s, {.threads = 1}));
      moves.push_back(terrain::nodeMoves(s));
    }
  }
};

// Two objects of the first model and one of the second.
server::SceneObjects threeObjects(size_t poses, const proto::Epochs& epochs) {
  const auto models = std::make_shared<Models>(poses);
  server::SceneObjects objects;
  std::vector<proto::ObjectModel> shapes;
  for (size_t i = 0; i < models->surfaces.size(); ++i) {
    const terrain::TrueSurface& s = models->surfaces[i];
    shapes.push_back({s.topology.shape(), s.quantum_m, s.base});
    for (uint32_t pose = 0; pose <= poses && poses > 0; ++pose) shapes.back().pose_epochs.push_back(pose);
    shapes.back().base_moves = terrain::baseMoves(s);
    objects.nodes.push_back({models->records[i], models->moves[i], poses});
  }
  objects.set = proto::ObjectSet::create(std::move(shapes),
                                         {{0, {40, 30, 200}, {0.5, 0.5, -0.1, 0.7}, 30},
                                          {0, {-20, 160, 230}, {1, 0, 0, 0}, 50},
                                          {1, {-110, -10, 235}, {0.1, -0.7, 0.5, 0.5}, 40}},
                                         epochs)
                    .value();
  objects.owner = models;
  return objects;
}

// Over low hills.
std::shared_ptr<const server::World> worldWithObjects() {
  FormulaSource source(65, 65, [](uint32_t x, uint32_t y) { return 0.15 * country(x, y, 0); });
  source.info().title = "objects";
  return std::make_shared<server::World>(makeScene(source), threeObjects(0, {}));
}

constexpr int64_t kDay_us = 86'400'000'000;

// The same while a corner of the ground sinks, and each object goes through three poses.
std::shared_ptr<const server::World> worldWithPoses() {
  FormulaSource source(65, 65, [](uint32_t x, uint32_t y) { return 0.15 * country(x, y, 0); });
  source.info().title = "poses";
  std::vector<FormulaSource> sources;
  for (uint32_t i = 0; i < 3; ++i)
    sources.push_back(windowSource(source, {30, 20, 20, 15}, [i](uint32_t x, uint32_t y) {
      return 0.15 * country(x, y, 0) - 20 * i * zigzag(x, 20) * zigzag(y, 15);
    }));
  std::vector<terrain::EpochRequest> epochs;
  for (uint32_t i = 0; i < 3; ++i)
    epochs.push_back({Time{(12'000 + i * i * 40) * kDay_us}, std::to_string(i), &sources[i]});
  const auto scene = makeScene(source, 0.1, 1, std::move(epochs));
  return std::make_shared<server::World>(scene, threeObjects(2, scene->epochs().epochs()));
}

proto::ViewRequest request(const proto::Lens& lens, double tau_px, proto::Strategy strategy, proto::Predictor predictor,
                           uint32_t memory_bytes = proto::kDefaultMemoryBytes) {
  proto::ViewRequest request{lens, tau_px, strategy, predictor, Duration::milliseconds(200)};
  request.memory_bytes = memory_bytes;
  return request;
}

// With `predict`: straight on, a turn, a climb; then another tolerance, a lost connection after which the section is
// presented, another lens, a budget, and at last a known path.
Script planarScript() {
  using enum proto::Predictor;
  constexpr auto kPredict = proto::Strategy::kPredict;
  Script s{"planar", worldOf(proto::FrameKind::kPlanar), {}, {}, at(1000)};
  s.route = {{at(0), {-600, -400, 900}, {1, 0.5, -0.4}},    {at(3), {-300, -200, 800}, {1, 0.6, -0.5}},
             {at(4.5), {-150, -100, 780}, {-0.2, 1, -0.5}}, {at(6), {-150, 50, 900}, {-0.4, 1, -0.9}},
             {at(8), {100, 150, 1500}, {0.3, 0.3, -1}},     {at(10), {300, 0, 700}, {-1, -0.1, -0.2}}};
  proto::ViewRequest limited = request({0.8, 400, 300}, 3, kPredict, kConstantAcceleration);
  limited.max_triangles = 2500;
  const Bytes closer = proto::encode(request({1.0, 320, 240}, 11, kPredict, kConstantVelocity));
  s.cues = {{at(0), proto::encode(request({1.0, 320, 240}, 14, kPredict, kConstantVelocity)), Cue::What::kConnect},
            {at(0.5), proto::encode(proto::TourRequest{7, "survey", 1})},
            {at(3.2), closer},
            {at(4.01), {}, Cue::What::kDisconnect},
            {at(4.5), closer, Cue::What::kConnect},
            {at(5.2), proto::encode(limited)},
            {at(7), proto::encode(proto::GroundRequest{8, {{3, 4}, {20.5, 100.25}, {179.5, 3}}})},
            {at(7.9), proto::encode(proto::SightRequest{9, {{3, 4, 2}, {60, 70.5, 0}, {-1, 4, 2}, {5, 5, 0}}})},
            {at(8), proto::encode(proto::ViewshedRequest{10, {40, 40.5}, 2, 0, 200, 20})},
            {at(8.1), proto::encode(proto::RequestCancel{11})},
            {at(8.2), proto::encode(proto::ViewshedRequest{12, {-40, 40.5}, 2, 0, 200, 20})}};
  proto::Path path{Time{} + s.clock_offset + at(7.5), Duration::milliseconds(500), {}};
  for (double t = 7.5; t <= 10; t += 0.5) path.poses.push_back(s.poseAt(at(t)));
  s.cues.push_back({at(7.2), proto::encode(path)});
  s.cues.push_back({at(7.4), proto::encode(request({1.2, 320, 240}, 5, kPredict, kKnownPath))});
  return s;
}

// With `delay` and `current`: around a valley, then away from it. A server with a smaller limit does not accept the
// section that is presented. There is memory for few pages. The session ends with a request that is refused.
Script geographicScript() {
  using enum proto::Strategy;
  constexpr auto kVelocity = proto::Predictor::kConstantVelocity;
  Script s{"geographic", worldOf(proto::FrameKind::kGeographic), {}, {}, at(-3.25)};
  s.route = {{at(0), {-2500, -3000, 1200}, {0.4, 1, -0.3}},
             {at(3), {-2400, -1800, 900}, {0.8, 1, -0.2}},
             {at(5), {-1200, 0, 1000}, {1, -0.3, -0.4}},
             {at(6.5), {0, 200, 3000}, {0.1, 0.1, -1}},
             {at(8), {200, -600, 1500}, {0.2, -1, -0.6}}};
  const Bytes narrow = proto::encode(request({0.6, 200, 320}, 2, kCurrent, kVelocity));
  s.cues = {{at(0), proto::encode(request({1.1, 320, 200}, 1.5, kDelay, kVelocity, 6'000)), Cue::What::kConnect},
            {at(2.6), proto::encode(request({1.1, 320, 200}, 1, kCurrent, kVelocity))},
            {at(4.4), narrow},
            {at(5.63), {}, Cue::What::kDisconnect},
            {at(5.8), narrow, Cue::What::kConnect, 500},
            {at(7.6), proto::encode(proto::TourRequest{1, "elsewhere", 10})}};
  return s;
}

// Past objects and around them, with another tolerance, a lost connection after which all sections are resumed from,
// and another lens.
Script objectsScript(const char* name, std::shared_ptr<const server::World> world) {
  constexpr auto kVelocity = proto::Predictor::kConstantVelocity;
  constexpr auto kPredict = proto::Strategy::kPredict;
  Script s{name, std::move(world), {}, {}, at(50)};
  s.route = {{at(0), {-300, -260, 320}, {1, 0.9, -0.3}},
             {at(2), {-100, -80, 260}, {1, 0.8, -0.3}},
             {at(3), {-30, -20, 230}, {1, 0.4, -0.2}},
             {at(4.5), {150, 100, 260}, {-1, -0.5, -0.4}}};
  const Bytes closer = proto::encode(request({1.0, 320, 240}, 3, kPredict, kVelocity));
  s.cues = {{at(0), proto::encode(request({1.0, 320, 240}, 5, kPredict, kVelocity, 2'000)), Cue::What::kConnect},
            {at(1.3), closer},
            {at(2.21), {}, Cue::What::kDisconnect},
            {at(2.6), closer, Cue::What::kConnect},
            {at(3.5), proto::encode(request({0.7, 300, 300}, 4, kPredict, kVelocity))}};
  return s;
}

// Ground that changes three times, in windows that overlap; the last reaches the border of the data.
std::shared_ptr<const server::World> worldThatMoves(proto::EpochBlend blend) {
  FormulaSource source(100, 90, [](uint32_t x, uint32_t y) { return country(x, y, 0); });
  source.info().title = "moving";
  std::vector<FormulaSource> sources;
  const proto::LatticeWindow windows[] = {{0, 0, 2, 2}, {20, 15, 40, 30}, {30, 25, 50, 40}, {45, 40, 55, 50}};
  for (uint32_t i = 0; i < 4; ++i)
    sources.push_back(windowSource(source, windows[i], [i](uint32_t x, uint32_t y) {
      return country(x, y, 0) + 30 * i * zigzag(x + 0.5 * y, 70) * zigzag(y, 45);
    }));
  std::vector<terrain::EpochRequest> epochs;
  for (uint32_t i = 0; i < 4; ++i)
    epochs.push_back({Time{(12'000 + i * i * 30) * kDay_us}, std::to_string(i), &sources[i]});
  return std::make_shared<server::World>(makeScene(source, 0.1, 1, std::move(epochs), blend));
}

// The same while scene time runs.
Script posesScript() {
  Script s = objectsScript("poses", worldWithPoses());
  const proto::SceneClock clock{Time{} + s.clock_offset + at(0.4), Time{12'000 * kDay_us}, 50 * 86'400.0};
  s.cues.insert(std::ranges::upper_bound(s.cues, at(0.4), {}, &Cue::at), {at(0.4), proto::encode(clock)});
  return s;
}

// Scene time stands, runs, is dragged backwards, runs backwards; a lost connection is resumed in mid-time.
Script movingScript(const char* name, proto::EpochBlend blend) {
  constexpr auto kVelocity = proto::Predictor::kConstantVelocity;
  constexpr double kDay = 86'400;
  Script s{name, worldThatMoves(blend), {}, {}, at(20)};
  s.route = {{at(0), {-450, -500, 700}, {1, 0.9, -0.6}},
             {at(3), {-200, -250, 600}, {0.7, 0.9, -0.7}},
             {at(6), {100, -200, 650}, {-0.2, 0.9, -0.7}}};
  const Bytes greeting = proto::encode(request({1.0, 320, 240}, 6, proto::Strategy::kPredict, kVelocity));
  const auto clock = [&](double begin_s, double day, double days_per_s) {
    return proto::encode(
        proto::SceneClock{Time{} + s.clock_offset + at(begin_s), Time::seconds(day * kDay), days_per_s * kDay});
  };
  s.cues = {{at(0), greeting, Cue::What::kConnect}, {at(0.7), clock(0.8, 12'000, 60)},
            {at(2.5), {}, Cue::What::kDisconnect},  {at(2.9), greeting, Cue::What::kConnect},
            {at(3.0), clock(0.8, 12'000, 60)},      {at(4.2), clock(4.2, 12'031.5, 0)},
            {at(4.8), clock(4.8, 12'260, -200)}};
  return s;
}

// Over country that is fine in two places, with little memory, which forgets pages and asks about them again; a lost
// connection after which the section is presented.
Script sparseScript() {
  constexpr auto kPath = proto::Predictor::kConstantVelocity;
  const auto scene = makeSparseScene(300, 200, [](uint32_t x, uint32_t y) { return country(x, y, 90); },
                                     proto::FrameKind::kPlanar, 4, {{70, 60, 25}, {200, 130, 12}});
  Script s{"sparse", std::make_shared<server::World>(scene), {}, {}, at(12.5)};
  s.route = {{at(0), {-1200, -700, 900}, {1, 0.7, -0.5}},
             {at(2.5), {-700, -300, 500}, {1, 0.6, -0.5}},
             {at(4), {-300, 0, 700}, {0.9, 0.6, -0.8}},
             {at(5), {-200, 0, 800}, {-1, -0.5, -0.8}},
             {at(7), {400, 200, 600}, {0.5, 0.4, -0.6}}};
  const Bytes greeting = proto::encode(request({1.0, 320, 240}, 6, proto::Strategy::kPredict, kPath, 20'000));
  s.cues = {{at(0), greeting, Cue::What::kConnect},
            {at(3.01), {}, Cue::What::kDisconnect},
            {at(3.4), greeting, Cue::What::kConnect}};
  return s;
}

// Over a small globe that is fine about a corner of its cube and a pole: down to the corner, over edges, and across the
// pole; little memory, and a lost connection after which the section is presented.
Script globeScript() {
  constexpr auto kVelocity = proto::Predictor::kConstantVelocity;
  Script s{"globe", std::make_shared<server::World>(makeGlobeScene(5, 11, 3)), {}, {}, at(7)};
  s.route = {{at(0), {70'000, 12'000, 9'000}, {-1, 0, -0.1}},
             {at(2), {15'500, -14'500, -12'500}, {-1, 1, 0.7}},
             {at(4), {14'000, -10'500, -12'800}, {-0.6, 1, 0.4}},
             {at(5.5), {13'000, 2'000, 17'500}, {-1, 0.3, -0.1}},
             {at(7.5), {-2'000, 1'000, 20'500}, {-1, 0.2, -0.4}}};
  const Bytes greeting = proto::encode(request({1.0, 320, 240}, 8, proto::Strategy::kPredict, kVelocity, 20'000));
  s.cues = {{at(0), greeting, Cue::What::kConnect},
            {at(0.6), proto::encode(proto::TourRequest{7, "pole", 2})},
            {at(3.01), {}, Cue::What::kDisconnect},
            {at(3.4), greeting, Cue::What::kConnect},
            {at(5), proto::encode(request({0.8, 400, 300}, 5, proto::Strategy::kCurrent, kVelocity, 20'000))}};
  return s;
}

}  // namespace

proto::Pose Script::poseAt(Duration t) const {
  size_t i = 1;
  while (i + 1 < route.size() && route[i].at < t) ++i;
  const Waypoint &a = route[i - 1], &b = route[i];
  const double u = std::min(1.0, (t - a.at).toSeconds() / (b.at - a.at).toSeconds());
  return {a.eye + (b.eye - a.eye) * u, proto::lookAlong(a.ahead + (b.ahead - a.ahead) * u, {0, 0, 1})};
}

std::vector<Script> goldenScripts() {
  return {planarScript(),
          geographicScript(),
          objectsScript("objects", worldWithObjects()),
          posesScript(),
          movingScript("moving", proto::EpochBlend::kLinear),
          movingScript("moving-catmull-rom", proto::EpochBlend::kCatmullRom),
          movingScript("moving-b-spline", proto::EpochBlend::kBSpline),
          sparseScript(),
          globeScript()};
}

}  // namespace foreland::test
