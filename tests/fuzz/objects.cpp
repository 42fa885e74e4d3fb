// Takes any bytes as changes of objects, keyframe after keyframe (tests/fuzz/toy_objects.h). Each one must lead to
// closed sections all of whose nodes have positions, or be refused.
#include "base/check.h"
#include "proto/codec/object_stream.h"
#include "tests/fuzz/toy_objects.h"

namespace foreland::proto {
namespace {

void validate(const ObjectStream& stream, size_t object) {
  stream.cut(object).validate();
  for (const Slot slot : stream.section(object).slots) {
    const glm::ivec3& at = stream.position(object, slot);
    for (int axis = 0; axis < 3; ++axis) {
      CHECK_LE(std::abs(at[axis]), kMaxObjectQuanta);
      for (const glm::ivec3& move : stream.moves(object, slot))
        CHECK_LE(std::abs(int64_t{at[axis]} + move[axis]), int64_t{kMaxObjectQuanta});
    }
  }
}

void run(ByteSpan bytes) {
  static const ObjectStream begin(test::toyObjects());
  if (bytes.empty()) return;
  ObjectStream stream = begin;
  CutDelta delta;
  test::forEachToyDelta(bytes.subspan(1), [&](int step, ByteSpan exact) {
    RangeDecoder coder(exact);
    stream.begin(test::toyFlightView(bytes[0], step));
    for (size_t object = 0; object < test::toyObjects().size(); ++object) {
      if (!stream.decode(object, coder, delta)) return false;
      validate(stream, object);
    }
    return true;
  });
}

}  // namespace
}  // namespace foreland::proto

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  foreland::proto::run({data, size});
  return 0;
}
