// Opens a changed scene file, or any bytes as one (tests/fuzz/changed_file.h), and sends a short flight over it: the
// first byte selects the flight, the rest is the file. Whatever heights, errors and radii the file claims, both ends
// hold the same closed sections, or the client notices within four keyframes and refuses (displacements that do not
// follow from the heights mislead the coder's contexts, which differ then).
#include <algorithm>
#include <optional>

#include "base/check.h"
#include "client/replica.h"
#include "server/section/ground_motion.h"
#include "server/section/sender.h"
#include "server/session/world.h"
#include "server/view/ground.h"
#include "terrain/store/mapped_scene.h"
#include "tests/fuzz/changed_file.h"
#include "tests/fuzz/toy_flight.h"

namespace foreland::test {
namespace {

constexpr size_t kMaxNodes = 4000;
constexpr int kUnnoticed = 3;  // keyframes, since each tells a quarter of the fingerprint

// Near the middle of the scene, low or high, looking down ahead and back.
proto::View viewAt(uint8_t how, int step, double ground) {
  const double side = step % 3 == 1 ? -1 : 1;
  proto::View view;
  view.pose = {{-15.0 * side + 4 * (how >> 5), 10.0 - 5 * step, ground + 60.0 + 20 * (how >> 3 & 3) + 10 * step},
               proto::lookAlong({0.4 * side, 0.2, -0.9}, {0, 0, 1})};
  view.tau_px = 0.5f;
  view.region_radius_m = static_cast<float>(step);
  return view;
}

// However fast the ground moves, a step comes nearer to where it leads, and not past it.
Time stepTowards(const server::GroundMotion& motion, Time from, Time wanted, const proto::View& view) {
  const Time to = motion.towards(from, wanted, view);
  CHECK_TRUE(wanted == from ? to == wanted : wanted > from ? to > from && to <= wanted : to < from && to >= wanted);
  return to;
}

void fly(const server::Hierarchy& hierarchy, uint8_t how) {
  static server::SendScratch scratch;
  server::SectionSender sender(hierarchy);
  sender.setMemory(static_cast<uint32_t>(toyFlightMemory(how)));
  proto::Welcome welcome = server::welcomeTo(hierarchy);
  welcome.memory_bytes = static_cast<uint32_t>(toyFlightMemory(how));
  client::Replica replica(welcome);
  proto::KeyframeMemory memory;
  constexpr double kHighest = 1e5;
  const double ground =
      std::clamp<double>(server::groundHeight(hierarchy.scene(), 0, 0).value_or(0), -kHighest, kHighest);
  int different = 0;  // keyframes on end after which the sections were not the same
  const proto::Epochs& epochs = hierarchy.epochs().epochs();
  std::optional<server::GroundMotion> motion;
  if (epochs.blend() != proto::EpochBlend::kLinear) motion.emplace(hierarchy);
  Time shown;
  for (int step = 0; step < kToySteps; ++step) {
    const proto::View view = viewAt(how, step, ground);
    if (!epochs.empty()) {
      const double span = static_cast<double>(epochs.last().us) - static_cast<double>(epochs.first().us);
      const Time wanted = epochs.clamp(static_cast<double>(epochs.first().us) + span * ((how + 3 * step) % 8) / 7);
      shown = motion && step % 3 != 0 ? stepTowards(*motion, shown, wanted, view) : wanted;
      sender.showAt(shown, step % 3 != 0);
    }
    Bytes message;
    if (!sender.send(view, Time{step * 200'000}, kMaxNodes, scratch, message)) return;
    auto decoded = proto::decodeServerMessage(message, memory);
    CHECK_TRUE(decoded.ok());
    const auto& keyframe = std::get<proto::KeyframeMessage>(*decoded);
    if (!replica.apply(keyframe.header, keyframe.delta).ok()) return;
    CHECK_TRUE(validate(hierarchy.grid(), replica.section()).ok());
    different = replica.section() == sender.adapter().section() ? 0 : different + 1;
    CHECK_LE(different, kUnnoticed);
  }
}

void run(ByteSpan bytes) {
  if (bytes.empty()) return;
  auto file = fileOf(bytes.subspan(1), soundScenes());
  const ByteSpan content = file->span();
  const auto scene = terrain::MappedScene::of(content, "fuzzed", std::move(file));
  if (!scene) return;
  auto objects = server::objectsOf(*scene);
  if (!objects) return;
  fly(server::Hierarchy(*scene, proto::ErrorBound::kSpheroid, std::move(*objects)), bytes[0]);
}

}  // namespace
}  // namespace foreland::test

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  foreland::test::run({data, size});
  return 0;
}
