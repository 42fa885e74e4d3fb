#include "sim/world.h"

#include <algorithm>
#include <utility>

#include "server/view/tour.h"
#include "sim/framing.h"
#include "sim/thread_time.h"

namespace foreland::sim {

namespace {

void earliest(std::optional<Time>& best, std::optional<Time> t) {
  if (t && (!best || *t < *best)) best = t;
}

}  // namespace

ClientOptions onKnownTour(const terrain::Scene& scene, const std::string& tour, double seconds) {
  ClientOptions c;
  c.request.lens = {1.0471975511965976, 480, 270};
  c.request.strategy = proto::Strategy::kPredict;
  c.request.predictor = proto::Predictor::kKnownPath;
  c.path = server::planTour(scene, tour, seconds).value();
  c.announce_path = true;
  return c;
}

World::World(std::shared_ptr<const terrain::Scene> scene, const server::SessionOptions& options, Duration compute_time,
             uint64_t seed, server::SceneObjects objects)
    : World(
          std::make_shared<server::World>(std::move(scene), std::move(objects)), options,
          [compute_time](const StepWork&) { return compute_time; }, seed) {}

World::World(std::shared_ptr<const server::World> world, const server::SessionOptions& options,
             ComputeTime compute_time, uint64_t seed, Laws laws)
    : world_(std::move(world)), options_(options), compute_time_(std::move(compute_time)), laws_(laws), seed_(seed) {}

size_t World::addClient(const ClientOptions& options) {
  clients_.push_back(std::make_unique<Client>(options, world_, options_, seed_ + 1000 * clients_.size()));
  clients_.back()->next_frame = now_;
  clients_.back()->chance = Rng(seed_ + clients_.size());
  return clients_.size() - 1;
}

void World::loseConnection(size_t client) { lose(*clients_[client]); }

void World::migrate(size_t client) { clients_[client]->live.migration.ask(now_); }

void World::overtake(size_t client, Duration late) {
  Client& c = *clients_[client];
  if (!c.is_connected || c.live.has_left) return;
  const uint64_t keyframes = c.live.session.statistics().keyframes;
  c.abandoned.push_back({std::move(c.live), now_ + late, keyframes});
  renew(c);
  connectAgain(client);
}

void World::stall(size_t client, Time end) {
  clients_[client]->live.up.stall(now_, end);
  clients_[client]->live.down.stall(now_, end);
}

void World::stopCorruption() {
  for (auto& c : clients_) {
    c->options.corrupt_one_in = 0;
    if (c->cut_at) lose(*c);
  }
}

// Whether the message at hand is to be changed.
bool World::corrupts(Client& c, Time now) {
  constexpr int64_t kCutWithin_us = 400'000;
  if (c.options.corrupt_one_in == 0 || c.chance.below(c.options.corrupt_one_in) != 0) return false;
  c.was_corrupted = true;
  if (!c.cut_at) c.cut_at = now + Duration{static_cast<int64_t>(c.chance.below(kCutWithin_us))};
  return true;
}

void World::lose(Client& c) {
  c.is_connected = false;
  renew(c);
}

// Of the connection, which is to be made again.
void World::renew(Client& c) {
  c.cut_at.reset();
  c.connects_at.reset();
  c.live = Connection(c.options, world_, options_, seed_ + 7 * ++c.connections);
  c.poses_counted = {};
  c.keyframes_counted = {};
}

void World::connectAgain(size_t client, std::shared_ptr<const terrain::Scene> scene) {
  Client& c = *clients_[client];
  if (scene) {
    c.live.session = server::Session(std::make_shared<server::World>(std::move(scene)), options_);
    c.scene_changed = true;
  }
  c.is_connected = true;
  c.connects_at.reset();
  c.viewer.reconnect(now_ + c.options.clock_offset);
}

void World::run(Time end) {
  while (true) {
    std::optional<Time> next;
    size_t who = 0;
    for (size_t i = 0; i < clients_.size(); ++i)
      if (const auto t = nextEvent(*clients_[i]); t && (!next || *t < *next)) next = t, who = i;
    if (!next || *next > end) break;
    now_ = std::max(now_, *next);
    handle(*clients_[who], who, now_);
  }
  now_ = end;
}

std::optional<Time> World::nextEvent(const Client& c) const {
  std::optional<Time> best = c.next_frame;
  earliest(best, nextEvent(c.live, now_));
  earliest(best, c.live.down.nextArrival());
  for (const Abandoned& a : c.abandoned) {
    earliest(best, nextEvent(a.connection, now_));
    earliest(best, a.end);
  }
  if (c.cut_at) earliest(best, std::max(*c.cut_at, now_));
  if (c.connects_at) earliest(best, std::max(*c.connects_at, now_));
  return best;
}

// At the server.
std::optional<Time> World::nextEvent(const Connection& c, Time now) {
  std::optional<Time> best;
  earliest(best, c.up.nextArrival());
  if (c.has_left) return best;
  if (c.waits_for_drain) earliest(best, std::max(c.down.drainedAt(), now));
  if (const auto due = c.session.due()) earliest(best, std::max(due->release, now));
  if (c.migration.isAsked()) earliest(best, std::max(c.has_greeted ? c.migration.latest() : now, now));
  return best;
}

void World::handle(Client& c, size_t index, Time now) {
  if (c.cut_at && *c.cut_at <= now) lose(c);
  if (c.connects_at && *c.connects_at <= now) connectAgain(index);
  if (!drive(c, c.live, now)) lose(c);
  endAbandoned(c, now);
  while (c.live.down.nextArrival() && *c.live.down.nextArrival() <= now) receive(c, index, now);
  if (c.next_frame <= now) frame(c, index, now);
  flush(c, now);
}

bool World::drive(Client& client, Connection& c, Time now) {
  if (c.waits_for_drain && c.down.drainedAt() <= now) {
    c.waits_for_drain = false;
    c.migration.leavesOnceSent() ? leaveForAnother(c, now) : c.session.onDrained(now);
  }
  while (c.up.nextArrival() && *c.up.nextArrival() <= now) {
    const Bytes message = c.up.receive();
    if (c.has_left) continue;
    c.has_greeted = true;
    if (const Status s = c.session.receive(message, now); !s.ok()) {
      const bool is_expected = &c == &client.live ? client.cut_at.has_value() : client.was_corrupted;
      if (!is_expected) complain("server refuses: " + s.error().message);
      return false;
    }
  }
  if (!c.has_left && c.migration.isOverdue(now, c.has_greeted)) leaveForAnother(c, now);
  if (c.has_left) return true;
  if (const auto due = c.session.due(); due && due->release <= now) serve(client, c, now);
  return true;
}

// The end stands behind what has left the server.
void World::leaveForAnother(Connection& c, Time now) {
  c.has_left = true;
  c.waits_for_drain = false;
  c.down.dropUnsent(now);
  c.down.send({}, now);
}

// What a session may make for nobody is bounded by the keyframes that it sends without being told that they arrive.
void World::endAbandoned(Client& client, Time now) {
  std::erase_if(client.abandoned, [&](Abandoned& a) {
    const bool is_over = a.end <= now || !drive(client, a.connection, now) || a.connection.has_left;
    while (a.connection.down.nextArrival() && *a.connection.down.nextArrival() <= now)
      (void)a.connection.down.receive();
    if (a.connection.session.statistics().keyframes > a.keyframes + options_.max_unacknowledged)
      complain("a session goes on with nobody at the other end");
    return is_over;
  });
}

void World::serve(Client& client, Connection& c, Time now) {
  const server::SessionStatistics before = c.session.statistics();
  std::vector<Bytes> out;
  const double begin_s = on_step ? threadSeconds() : 0;
  c.session.step(now, scratch_, out);
  const double real_s = on_step ? threadSeconds() - begin_s : 0;
  uint64_t bytes = 0;
  for (const Bytes& message : out) bytes += message.size();
  const StepWork work = StepWork::between(before, c.session, bytes);
  if (on_step) on_step(work, real_s);
  const Duration spent = compute_time_(work);
  c.session.noteComputeTime(spent);
  if (work.keyframes > 0) keep(c, now, work, spent);
  for (Bytes& message : out) {
    client.traffic.largest_down = std::max(client.traffic.largest_down, message.size());
    c.down.send(std::move(message), now + (work.keyframes > 0 ? spent : Duration{}));
  }
  client.traffic.max_unsent_bytes = std::max(client.traffic.max_unsent_bytes, c.down.unsentBytes(now));
  if (!out.empty()) c.waits_for_drain = true;
}

void World::keep(Connection& c, Time now, const StepWork& work, Duration spent) {
  Connection::Sent& sent = c.sections[c.session.keyframe().index];
  sent.work = work;
  sent.computed = spent;
  if (laws_ == Laws::kTrusted) return;
  if (c.waits_for_drain && c.down.drainedAt() > now) complain("a second delta was made while one was unsent");
  sent.section = c.session.section();
  sent.known = c.session.knownPages();
  if (const Status s = proto::validate(c.session.world().hierarchy.grid(), sent.section); !s.ok())
    complain(s.error().message);
}

namespace {

// Whether the client has the true heights of all nodes that it knows, and the true errors of those that are settled.
bool knowsTheTruth(const client::Replica& replica, const server::Hierarchy& hierarchy) {
  bool is_true = true;
  for (const proto::KnownPage& page : replica.knownPages())
    page.knowledge.known.forEach([&](uint8_t low) {
      const proto::Slot slot = page.first | low;
      const proto::NodeRecord &held = replica.nodes().records().at(slot), &truth = hierarchy.nodes()[slot];
      is_true = is_true && held.height() == truth.height() && held.displacement() == truth.displacement();
      if (page.knowledge.settled.has(low)) is_true = is_true && held.error() == truth.error();
      is_true = is_true && truth.error() >= page.knowledge.finest;
    });
  return is_true;
}

// Whether the client draws every node of its section at the height that the ground has at the keyframe's scene time.
bool movesTruly(const client::Replica& replica, const server::Hierarchy& hierarchy) {
  const terrain::EpochTable& table = hierarchy.epochs();
  if (table.epochs().empty()) return true;
  const proto::GridTopology& grid = hierarchy.grid();
  const proto::EpochWeights weights = table.epochs().weightsAt(replica.newest().scene_time);
  const client::EndHeights heights = replica.heights();
  return std::ranges::all_of(replica.section().slots, [&](proto::Slot slot) {
    const proto::NodeId n = grid.node(slot);
    double truth = 0;
    for (uint32_t i = 0; i < weights.count; ++i) truth += weights.weight[i] * table.offset(weights.epoch[i], grid, n);
    const int32_t height = replica.nodes().records().at(slot).height();
    return heights.at(n, height, 1) == hierarchy.nodes()[slot].height() + truth;
  });
}

}  // namespace

void World::receive(Client& c, size_t index, Time now) {
  Bytes message = c.live.down.receive();
  if (!c.is_connected) return;
  if (message.empty()) {  // the server's end of the connection
    // A round trip each for the new connection and for WebSocket's greeting.
    const Duration round_trip = c.options.up.latency + c.options.down.latency;
    ++c.migrations;
    lose(c);
    c.connects_at = now + round_trip * 2;
    return;
  }
  if (corrupts(c, now)) message[0] = 0xff;
  for (uint8_t byte : message) c.hash.add(byte);
  countDown(c, message);
  const bool holds_something = c.viewer.replica() && c.viewer.replica()->newest().index > 0;
  const uint32_t started_afresh = c.viewer.statistics().started_afresh;
  if (const Status s = c.viewer.receive(message, now + c.options.clock_offset); !s.ok()) {
    if (!c.cut_at) complain("client refuses: " + s.error().message);
    return lose(c);
  }
  // What a time stamp that was changed on its way makes of a keyframe's time may be too far ahead to go on from.
  if (holds_something && c.viewer.statistics().started_afresh > started_afresh && !c.scene_changed && !c.was_corrupted)
    complain("a viewer that holds a section starts afresh");
  if (!c.viewer.replica()) return;
  const uint32_t keyframe = c.viewer.replica()->newest().index;
  const auto it = c.live.sections.find(keyframe);
  if (it == c.live.sections.end()) return;
  if (on_keyframe)
    on_keyframe(index, {now + c.options.clock_offset, message.size(), c.viewer.statistics().last_lateness,
                        it->second.work, it->second.computed});
  if (laws_ == Laws::kChecked) compare(c, keyframe, it->second);
  c.live.sections.erase(c.live.sections.begin(), std::next(it));
}

void World::compare(const Client& c, uint32_t keyframe, const Connection::Sent& sent) {
  const client::Replica& replica = *c.viewer.replica();
  if (replica.section() != sent.section) complain("client and server differ at keyframe " + std::to_string(keyframe));
  if (replica.knownPages() != sent.known)
    complain("client and server remember other nodes at keyframe " + std::to_string(keyframe));
  if (!movesTruly(replica, c.live.session.world().hierarchy))
    complain("the client shows the ground of another time at keyframe " + std::to_string(keyframe));
  if (keyframe % 16 == 0 && !knowsTheTruth(replica, c.live.session.world().hierarchy))
    complain("the client remembers another height or error at keyframe " + std::to_string(keyframe));
}

void World::frame(Client& c, size_t index, Time now) {
  c.next_frame = c.next_frame + kFrame;
  const Time now_client = now + c.options.clock_offset;
  if (c.options.at_frame) c.options.at_frame(c.viewer, now_client);
  if (c.options.announce_path && c.viewer.welcome() && !c.path_announced) {
    c.viewer.announcePath(c.options.path);
    c.path_announced = true;
  }
  const client::FrameView view =
      c.viewer.frame(now_client, c.options.camera ? c.options.camera(now_client) : c.options.path.at(now_client));
  if (std::exchange(c.has_mesh, view.mesh != nullptr) && !view.mesh && !c.scene_changed)
    complain("a mesh was shown and is gone");
  if (view.mesh && on_frame) on_frame(index, view, now_client);
}

void World::flush(Client& c, Time now) {
  Bytes message;
  while (c.viewer.takeOutgoing(message)) {
    if (!c.is_connected) continue;
    countUp(c, message);
    if (corrupts(c, now))
      for (uint64_t i = 1 + c.chance.below(4); i-- > 0;)
        message[c.chance.below(message.size())] = static_cast<uint8_t>(c.chance.next());
    c.live.up.send(std::move(message), now);
  }
}

void World::countDown(Client& c, const Bytes& message) {
  Traffic& t = c.traffic;
  t.framing_down += frameHeaderBytes(message.size(), Direction::kDown);
  const auto decoded = proto::decodeServerMessage(message, c.keyframes_counted);
  const auto* keyframe = decoded ? std::get_if<proto::KeyframeMessage>(&*decoded) : nullptr;
  if (!keyframe) return t.other_down.add(message.size());
  t.headers.add(message.size() - keyframe->delta.size());
  t.deltas.add(keyframe->delta.size());
}

void World::countUp(Client& c, const Bytes& message) {
  Traffic& t = c.traffic;
  t.framing_up += frameHeaderBytes(message.size(), Direction::kUp);
  const auto decoded = proto::decodeClientMessage(message, c.poses_counted);
  const bool is_pose = decoded && std::holds_alternative<proto::PoseUpdate>(*decoded);
  (is_pose ? t.poses : t.other_up).add(message.size());
}

std::string World::report() const {
  std::string all;
  for (const std::string& c : complaints_) all += c + "\n";
  return all;
}

}  // namespace foreland::sim
