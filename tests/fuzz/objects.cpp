// Any bytes as changes of objects, keyframe after keyframe (tests/fuzz/toy_objects.h): each leads to closed sections
// whose nodes have places, or is refused.
#include "base/check.h"
#include "proto/object_stream.h"
#include "tests/fuzz/toy_objects.h"

namespace foreland::proto {
namespace {

void run(ByteSpan bytes) {
  static const ObjectStream begin(test::toyObjects());
  if (bytes.empty()) return;
  const uint8_t how = bytes[0];
  bytes = bytes.subspan(1);
  ObjectStream stream = begin;
  CutDelta delta;
  for (int step = 0; step < test::kToySteps && bytes.size() >= 2; ++step) {
    const size_t size = std::min<size_t>(bytes[0] | bytes[1] << 8, bytes.size() - 2);
    const Bytes exact(bytes.begin() + 2, bytes.begin() + 2 + static_cast<ptrdiff_t>(size));
    RangeDecoder coder(exact);
    stream.begin(test::toyFlightView(how, step));
    for (size_t object = 0; object < test::toyObjects().size(); ++object) {
      if (!stream.decode(object, coder, delta)) return;
      stream.cut(object).validate();
      for (const Slot slot : stream.section(object).slots) {
        const glm::ivec3& at = stream.position(object, slot);
        for (int axis = 0; axis < 3; ++axis) CHECK_LE(std::abs(at[axis]), kMaxObjectSteps);
      }
    }
    bytes = bytes.subspan(2 + size);
  }
}

}  // namespace
}  // namespace foreland::proto

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  foreland::proto::run({data, size});
  return 0;
}
