// A session and a viewer that says anything at any time (tests/world/hostile_viewer.h), by the choices that any bytes
// stand for. The session must keep its limits, whatever it is told.
#include "base/check.h"
#include "tests/fuzz/fuzzed_choices.h"
#include "tests/support/scene.h"
#include "tests/world/hostile_viewer.h"

namespace foreland::test {
namespace {

constexpr int64_t kLongestWait_us = 60'000;

const std::shared_ptr<const server::World>& world() {
  static const auto made = std::make_shared<const server::World>(makeScene(33, 29, 3));
  return made;
}

server::SessionOptions limits() {
  server::SessionOptions options;
  options.max_section_nodes = 1500;
  options.max_added_nodes = 600;
  options.max_added_after_jump = 300;
  return options;
}

void run(ByteSpan bytes) {
  FuzzedChoices choices(bytes);
  HostileViewer viewer(world(), limits(), choices);
  for (Time now; !choices.isAtEnd();) {
    now = now + Duration{static_cast<int64_t>(choices.below(256)) * kLongestWait_us / 256};
    viewer.act(now);
    CHECK_EQ(viewer.report(), "");
  }
}

}  // namespace
}  // namespace foreland::test

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  foreland::test::run({data, size});
  return 0;
}
