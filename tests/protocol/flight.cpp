#include "tests/protocol/flight.h"

#include <algorithm>
#include <bit>
#include <deque>
#include <memory>

#include "proto/refine/places.h"
#include "server/session/session.h"
#include "tests/protocol/scripts.h"

namespace foreland::test {

namespace {

constexpr Duration kTick = Duration::milliseconds(10), kPoseInterval = Duration::milliseconds(100),
                   kWayDown = Duration::milliseconds(40), kDrain = Duration::milliseconds(20);

// Of integers, lowest byte first: the CRC-32 of zlib and of Ethernet.
class Crc {
 public:
  void add(uint32_t value) {
    for (int i = 0; i < 32; ++i, value >>= 1) crc_ = crc_ >> 1 ^ (((crc_ ^ value) & 1) != 0 ? 0xedb88320u : 0);
  }
  void add(double value) {
    const uint64_t bits = std::bit_cast<uint64_t>(value);
    add(static_cast<uint32_t>(bits));
    add(static_cast<uint32_t>(bits >> 32));
  }
  uint32_t value() const { return ~crc_; }

 private:
  uint32_t crc_ = ~0u;
};

// The least number from 0 to 10^30 that passes, to the last bit, or 10^30. `passes` grows with the number.
template <class Passes>
double leastNumber(const Passes& passes) {
  constexpr double kMost = 1e30;
  if (passes(0.0)) return 0;
  uint64_t low = 0, high = std::bit_cast<uint64_t>(kMost);
  while (high - low > 1) {
    const uint64_t middle = (low + high) / 2;
    (passes(std::bit_cast<double>(middle)) ? high : low) = middle;
  }
  return std::bit_cast<double>(high);
}

// What the refinement test makes of a section's nodes, to the last bit: places, radii, least classes that pass; and of
// some the least error and the least radius that pass.
template <class Places>
uint32_t testsCrc(const server::Hierarchy& h, const proto::Section& section, const proto::Metric& metric) {
  const Places places(h.domain(), metric);
  Crc crc;
  for (proto::Slot slot : section.slots) {
    const proto::NodeId n = h.grid().node(slot);
    const proto::NodeRecord& record = h.nodes()[slot];
    const auto x = static_cast<int32_t>(n.x()), y = static_cast<int32_t>(n.y());
    const proto::Metric::Place p = places(x, y, record.middle());
    const float radius = h.domain().radius_m(h.grid().level(n), record.radius());
    for (double value : {p.x, p.y, p.z, p.horizontal}) crc.add(value);
    crc.add(std::bit_cast<uint32_t>(radius));
    crc.add(static_cast<uint32_t>(metric.leastPassing(p, radius)));
    if (slot % 32 != 0) continue;
    crc.add(leastNumber([&](double error_m) { return metric.passes(p, radius, error_m); }));
    crc.add(leastNumber([&](double radius_m) { return metric.passes(p, radius_m, 1e30); }));
  }
  return crc.value();
}

class Recorder {
 public:
  explicit Recorder(const Script& script)
      : script_(script), world_(std::make_shared<server::World>(script.scene)), session_(world_, {}) {
    golden_.name = script.name;
    for (char c : std::string("FLSTREAM")) golden_.stream.push_back(static_cast<uint8_t>(c));
    golden_.expected = "# keyframe nodes added removed fingerprint slots_crc heights_crc tests_crc\n";
  }

  GoldenFlight run() {
    const Time end = Time{} + script_.route.back().at;
    for (now_ = Time{}; now_ <= end && !is_over_; now_ = now_ + kTick) tick();
    return std::move(golden_);
  }

 private:
  void tick() {
    for (; next_cue_ < script_.cues.size() && Time{} + script_.cues[next_cue_].at <= now_; ++next_cue_)
      up(script_.cues[next_cue_].message);
    while (!on_the_way_.empty() && on_the_way_.front().arrival <= now_) {
      received_ = on_the_way_.front();
      on_the_way_.pop_front();
    }
    if (now_.us % kPoseInterval.us == 0 && now_ > Time{}) sendPose();
    if (drained_at_ && *drained_at_ <= now_) {
      drained_at_.reset();
      session_.onDrained(now_);
    }
    while (!is_over_ && isDue()) step();
  }

  bool isDue() const {
    const auto due = session_.due();
    return due && due->release <= now_;
  }

  void sendPose() {
    proto::PoseUpdate update;
    update.pose = {now_ + script_.clock_offset, script_.poseAt(now_ - Time{})};
    update.received_keyframe = received_.index;
    update.received_at = received_.arrival + script_.clock_offset;
    up(proto::encode(update));
  }

  // As the server's host does: an error is said, and ends the session.
  void up(const Bytes& message) {
    record(0, message);
    const Status status = session_.receive(message, now_);
    if (status.ok()) return;
    record(1, proto::encode(proto::Refusal{status.error().message}));
    is_over_ = true;
  }

  void step() {
    const uint32_t before = session_.keyframe().index;
    std::vector<Bytes> out;
    session_.step(now_, scratch_, out);
    session_.noteComputeTime(Duration::milliseconds(5));
    for (const Bytes& message : out) record(1, message);
    if (session_.keyframe().index == before) return;
    on_the_way_.push_back({session_.keyframe().index, now_ + kWayDown});
    drained_at_ = now_ + kDrain;
    expect(session_.keyframe());
  }

  void record(uint8_t direction, const Bytes& message) {
    ByteWriter w(golden_.stream);
    w.put(direction);
    w.put(now_.us);
    w.put(static_cast<uint32_t>(message.size()));
    w.putBytes(message);
  }

  // What a viewer must hold at this keyframe, without anything that was sent.
  void expect(const proto::KeyframeHeader& keyframe) {
    const terrain::Scene& scene = world_->hierarchy.scene();
    const server::Hierarchy& hierarchy = world_->hierarchy;
    const proto::View view = proto::viewOf(keyframe);
    proto::RefineScratch scratch;
    proto::Section section;
    CHECK_TRUE(refine(hierarchy, view, scene.grid().slotCount(), scratch, section));
    CHECK_TRUE(section == session_.section());
    proto::CutDelta delta;
    proto::diff(held_, section, delta);
    Crc slots, heights;
    for (proto::Slot slot : section.slots) {
      slots.add(slot);
      heights.add(static_cast<uint32_t>(scene.nodes()[slot].height()));
    }
    const proto::Metric metric = hierarchy.domain().metric(view);
    const uint32_t tests = hierarchy.domain().isPlanar() ? testsCrc<proto::PlanarPlaces>(hierarchy, section, metric)
                                                         : testsCrc<proto::CurvedPlaces>(hierarchy, section, metric);
    char line[120];
    std::snprintf(line, sizeof(line), "%u %zu %zu %zu %08x %08x %08x %08x\n", keyframe.index, section.slots.size(),
                  delta.added.size(), delta.removed.size(), proto::fingerprint(section.slots), slots.value(),
                  heights.value(), tests);
    golden_.expected += line;
    held_ = std::move(section);
  }

  struct Arrival {
    uint32_t index = 0;
    Time arrival;
  };

  const Script& script_;
  std::shared_ptr<const server::World> world_;
  server::Session session_;
  server::SessionScratch scratch_;
  GoldenFlight golden_;
  Time now_;
  size_t next_cue_ = 0;
  std::deque<Arrival> on_the_way_;
  Arrival received_;
  std::optional<Time> drained_at_;
  bool is_over_ = false;
  proto::Section held_;
};

}  // namespace

std::vector<GoldenFlight> recordGoldenFlights() {
  std::vector<GoldenFlight> flights;
  for (const Script& script : goldenScripts()) flights.push_back(Recorder(script).run());
  return flights;
}

}  // namespace foreland::test
