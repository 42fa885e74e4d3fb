#include "tests/protocol/flight.h"

#include <deque>
#include <memory>
#include <optional>

#include "proto/codec/section_codec.h"
#include "server/session/session.h"
#include "tests/protocol/expectation.h"
#include "tests/protocol/scripts.h"

namespace foreland::test {

namespace {

constexpr Duration kTick = Duration::milliseconds(10), kPoseInterval = Duration::milliseconds(100),
                   kWayDown = Duration::milliseconds(40), kDrain = Duration::milliseconds(20);

enum class Record : uint8_t { kFromClient = 0, kFromServer = 1, kNewConnection = 2 };

class Recorder {
 public:
  explicit Recorder(const Script& script)
      : script_(script), world_(script.world), cues_(script.cues), sections_(emptySections(world_->hierarchy)) {
    golden_.name = script.name;
    for (char c : std::string("FLSTREAM")) golden_.stream.push_back(static_cast<uint8_t>(c));
    golden_.expected = "# keyframe nodes added removed fingerprint slots_crc heights_crc tests_crc";
    if (!sections_.objects.empty()) golden_.expected += " object_nodes added removed slots_crc positions_crc";
    if (!world_->hierarchy.epochs().epochs().empty()) golden_.expected += " offsets_crc";
    golden_.expected += '\n';
  }

  GoldenFlight run() {
    const Time end = Time{} + script_.route.back().at;
    for (; now_ <= end && !is_over_; now_ = now_ + kTick) {
      while (!cues_.empty() && Time{} + cues_.front().at <= now_ && !is_over_) play(cues_.front()), cues_.pop_front();
      if (connection_ && !is_over_) tick(*connection_);
    }
    return std::move(golden_);
  }

 private:
  // A message on its way down; of a keyframe also what it is.
  struct Packet {
    Time arrival;
    Bytes message;
    std::optional<proto::KeyframeHeader> keyframe;
    std::vector<proto::KnownPage> known = {};  // once it is taken
  };
  struct Connection {
    Connection(std::shared_ptr<const server::World> world, const server::SessionOptions& options)
        : session(std::move(world), options) {}
    server::Session session;
    std::deque<Packet> down;
    std::optional<Time> drained_at;
    bool is_greeted = false;
    proto::PoseMemory poses_sent;
    uint32_t received_keyframe = 0;
    Time received_at;
  };

  void play(const Cue& cue) {
    if (cue.what == Cue::What::kDisconnect) {
      connection_.reset();
      return;
    }
    if (cue.what == Cue::What::kConnect) {
      if (now_ > Time{}) record(Record::kNewConnection, {});
      server::SessionOptions options;
      options.max_section_nodes = cue.max_section_nodes;
      connection_ = std::make_unique<Connection>(world_, options);
    }
    up(*connection_, cue.message);
  }

  void tick(Connection& c) {
    while (!c.down.empty() && c.down.front().arrival <= now_) {
      receive(c, c.down.front());
      c.down.pop_front();
    }
    if (c.is_greeted && now_.us % kPoseInterval.us == 0) sendPose(c);
    if (c.drained_at && *c.drained_at <= now_) {
      c.drained_at.reset();
      c.session.onDrained(now_);
    }
    while (isDue(c)) step(c);
  }

  // ---- the viewer

  // The first message of a connection is the welcome.
  void receive(Connection& c, const Packet& packet) {
    record(Record::kFromServer, packet.message);
    if (!c.is_greeted && held_) resume(c);
    c.is_greeted = true;
    if (!packet.keyframe) return;
    const proto::KeyframeHeader& keyframe = *packet.keyframe;
    if (!held_ || keyframe.base_index == 0) sections_ = emptySections(world_->hierarchy);
    golden_.expected += expectedLine(world_->hierarchy, keyframe, sections_);
    held_ = keyframe;
    known_ = packet.known;
    sections_ = sectionsOf(world_->hierarchy, keyframe);
    c.received_keyframe = keyframe.index;
    c.received_at = now_ + script_.clock_offset;
  }

  void resume(Connection& c) {
    const server::Hierarchy& hierarchy = world_->hierarchy;
    proto::Resume resume{hierarchy.scene().id(), held_->index, held_->time, proto::fingerprint(sections_), {}};
    proto::HeldSections held = sections_;
    held.known = known_;
    proto::encodeSections(hierarchy.grid(), hierarchy.objects().set, held, resume.section);
    up(c, proto::encode(resume));
  }

  void sendPose(Connection& c) {
    const proto::PoseUpdate update{
        {now_ + script_.clock_offset, script_.poseAt(now_ - Time{})}, c.received_keyframe, c.received_at};
    up(c, proto::encode(update, c.poses_sent));
  }

  // ---- the server, and its host: an error is said, and ends the session

  void up(Connection& c, const Bytes& message) {
    record(Record::kFromClient, message);
    const Status status = c.session.receive(message, now_);
    if (status.ok()) return;
    record(Record::kFromServer, proto::encode(proto::Refusal{status.error().message}));
    is_over_ = true;
  }

  bool isDue(const Connection& c) const {
    const auto due = c.session.due();
    return due && due->release <= now_;
  }

  void step(Connection& c) {
    const uint64_t before = c.session.statistics().keyframes;
    std::vector<Bytes> out;
    c.session.step(now_, scratch_, out);
    c.session.noteComputeTime(Duration::milliseconds(5));
    for (Bytes& message : out) c.down.push_back({now_ + kWayDown, std::move(message), {}});
    if (!out.empty()) c.drained_at = now_ + kDrain;
    if (c.session.statistics().keyframes == before) return;
    c.down.back().keyframe = c.session.keyframe();
    c.down.back().known = c.session.knownPages();
    const proto::HeldSections exact = sectionsOf(world_->hierarchy, c.session.keyframe());
    CHECK_TRUE(exact.terrain == c.session.section());
    CHECK_EQ(proto::fingerprint(exact), c.session.keyframe().fingerprint);  // so objects' sections are exact, too
  }

  void record(Record what, const Bytes& message) {
    ByteWriter w(golden_.stream);
    w.put(what);
    w.put(now_.us);
    w.put(static_cast<uint32_t>(message.size()));
    w.putBytes(message);
  }

  const Script& script_;
  std::shared_ptr<const server::World> world_;
  server::SessionScratch scratch_;
  GoldenFlight golden_;
  Time now_;
  std::deque<Cue> cues_;
  std::unique_ptr<Connection> connection_;
  bool is_over_ = false;
  std::optional<proto::KeyframeHeader> held_;  // by the viewer
  proto::HeldSections sections_;               // of it
  std::vector<proto::KnownPage> known_;        // with it
};

}  // namespace

std::vector<GoldenFlight> recordGoldenFlights() {
  std::vector<GoldenFlight> flights;
  for (const Script& script : goldenScripts()) flights.push_back(Recorder(script).run());
  return flights;
}

}  // namespace foreland::test
