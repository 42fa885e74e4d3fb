// Both ends of a stream in one process: a server's session and a client, with nothing between them but messages. Read
// it from top to bottom; docs/HACKING.md goes on from here. Real programs put sockets between the ends
// (apps/serve/serve.cpp, apps/fly/fly.cpp), tests and experiments put links in virtual time (sim/world.h).
#include <cmath>
#include <cstdio>
#include <memory>
#include <utility>

#include "client/viewer.h"
#include "server/session/session.h"
#include "server/view/tour.h"
#include "terrain/pipeline/build.h"

using namespace foreland;

// Elevation comes by rows, of a file or of a formula: here, hills of 513 x 513 samples, 30 m apart.
class Hills : public terrain::ElevationSource {
 public:
  Hills() {
    info_.width = info_.height = 513;
    info_.frame.axis_x_m = {30, 0};
    info_.frame.axis_y_m = {0, 30};
    info_.title = "hills";
  }
  const terrain::ElevationInfo& info() const override { return info_; }
  Status readRows(uint32_t first, uint32_t count, std::span<float> metres) override {
    for (uint32_t i = 0; i < count * info_.width; ++i) {
      const double x = i % info_.width, y = first + i / info_.width;  // NOLINT(bugprone-integer-division): a row
      metres[i] = static_cast<float>(400 + 300 * std::sin(x / 31) * std::cos(y / 43) + 25 * std::sin(x / 5 + y / 7));
    }
    return {};
  }

 private:
  terrain::ElevationInfo info_;
};

int main(int argc, char** argv) {
  // 1. The owner of the data makes a scene file, once: errors, spheres and heights of all nodes. A server maps it.
  const char* file = argc > 1 ? argv[1] : "two_ends.fls";
  Hills hills;
  if (const auto built = terrain::buildScene(hills, {.output = file}); !built.ok())
    return std::fprintf(stderr, "%s\n", built.error().message.c_str()), 2;
  const auto scene = terrain::Scene::open(file);
  if (!scene.ok()) return std::fprintf(stderr, "%s\n", scene.error().message.c_str()), 2;

  // 2. The server has one world for all viewers, and a session for each. Neither knows a socket, a clock or a thread.
  const auto world = std::make_shared<const server::World>(*scene);
  server::Session session(world, {.tau_px = 1, .keyframe_interval = Duration::milliseconds(200)});
  server::SessionScratch scratch;  // working memory, which a worker lends

  // 3. The client asks for what it wants to see: here, a planned flight that it announces, so nothing is guessed.
  proto::ViewRequest request;
  request.lens = {1.05, 1920, 1080};  // radians, pixels
  request.predictor = proto::Predictor::kKnownPath;
  client::Viewer viewer(request);
  const auto path = server::planTour(**scene, "survey", 10);
  viewer.announcePath(path.value());

  // 4. Time is a parameter. Each millisecond the messages of either end go to the other; each 20th is a frame.
  uint64_t frames = 0, guaranteed = 0;
  std::printf("%4s %9s %11s %10s %8s\n", "s", "keyframe", "triangles", "bytes", "px");
  for (Time now; now < path->end(); now = now + Duration::milliseconds(1)) {
    for (Bytes message; viewer.takeOutgoing(message);)
      if (const Status s = session.receive(message, now); !s.ok()) return std::puts(s.error().message.c_str()), 1;
    std::vector<Bytes> down;
    if (const auto due = session.due(); due && due->release <= now) session.step(now, scratch, down);
    for (const Bytes& message : down)
      if (const Status s = viewer.receive(message, now); !s.ok()) return std::puts(s.error().message.c_str()), 1;
    if (!down.empty()) session.onDrained(now);  // all has been sent: the next keyframe may be computed

    if (now.us / 1000 % 20 != 0) continue;
    const client::FrameView frame = viewer.frame(now, path->at(now));  // the mesh, and one weight: all that is drawn
    if (!frame.mesh) continue;
    ++frames;
    guaranteed += frame.tolerance_px <= 1 ? 1 : 0;  // infinite where the camera has left the keyframes' regions
    if (now.us % 1'000'000 == 0)
      std::printf("%4.0f %9u %11zu %10llu %8.2f\n", now.toSeconds(), frame.mesh->to.index, frame.mesh->triangleCount(),
                  static_cast<unsigned long long>(viewer.statistics().bytes_down), frame.tolerance_px);
  }

  // 5. Both ends hold the same section, node for node, although no list of nodes was ever sent.
  const bool are_equal = viewer.replica()->section().slots == session.section().slots;
  std::printf("%llu frames, %llu within 1 pixel; sections %s\n", static_cast<unsigned long long>(frames),
              static_cast<unsigned long long>(guaranteed), are_equal ? "equal" : "differ");
  return are_equal && frames > 480 && guaranteed == frames ? 0 : 1;
}
