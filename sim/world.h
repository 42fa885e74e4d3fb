// A small world in virtual time: the real session and viewer cores, seeded links between them, no sockets, no clock.
// Minutes of flight run in seconds, and the same seed gives the same bytes. Tests and experiments use the same world;
// after each event the laws of a session are checked, unless an experiment takes them as proved. One owner.
#pragma once

#include <algorithm>
#include <deque>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "base/fnv1a.h"
#include "client/viewer.h"
#include "server/session/migration.h"
#include "server/session/session.h"
#include "sim/compute_cost.h"
#include "sim/link.h"

namespace foreland::sim {

struct ClientOptions {
  proto::ViewRequest request;
  LinkOptions up, down;
  proto::Path path;  // flown from its start; the client's clock
  bool announce_path = false;
  std::function<proto::Pose(Time)> camera;  // flown instead of the path, if not empty
  // One message in so many is changed on its way, either way, and its connection is cut soon after; 0: none. What is
  // changed on the way down is no message any more, since a viewer may take another keyframe for the one that was sent.
  uint64_t corrupt_one_in = 0;
  Duration clock_offset;                                // client's clock minus the server's
  std::function<void(client::Viewer&, Time)> at_frame;  // called before each frame
};

// What has gone over a client's links, message by message as it arrived or was handed over.
struct Traffic {
  struct Part {
    uint64_t messages = 0, bytes = 0;
    size_t largest = 0;  // after the first
    void add(size_t size) {
      if (messages > 0) largest = std::max(largest, size);
      ++messages;
      bytes += size;
    }
    double mean() const { return static_cast<double>(bytes) / static_cast<double>(std::max<uint64_t>(messages, 1)); }
  };
  Part headers, deltas, other_down;           // down: of keyframes; everything else
  Part poses, other_up;                       // up
  uint64_t framing_down = 0, framing_up = 0;  // what carries the messages: bytes of WebSocket
  size_t max_unsent_bytes = 0, largest_down = 0;
};

// A keyframe as it arrived.
struct ArrivedKeyframe {
  Time at;  // the client's clock
  size_t bytes = 0;
  Duration lateness;  // negative is early
  StepWork work;      // that the server did for it
  Duration computed;  // what that took
};

enum class Laws : uint8_t { kChecked, kTrusted };

// Predicts along a tour that it announces, on a small screen.
ClientOptions onKnownTour(const terrain::Scene& scene, const std::string& tour, double seconds);

class World {
 public:
  static constexpr Duration kFrame{16'667};  // between two frames of a client

  // Every step of a session takes `compute_time`, or as long as its work costs. There are as many workers as clients.
  World(std::shared_ptr<const terrain::Scene> scene, const server::SessionOptions& options, Duration compute_time,
        uint64_t seed, server::SceneObjects objects = {});
  World(std::shared_ptr<const server::World> world, const server::SessionOptions& options, ComputeTime compute_time,
        uint64_t seed, Laws laws = Laws::kChecked);

  size_t addClient(const ClientOptions& options);
  // The client's server dies with its connection, and what was under way is lost; the client flies on.
  void loseConnection(size_t client);
  bool isConnected(size_t client) const { return clients_[client]->is_connected; }
  // The client's server is drained: it asks the client to go on at another one, which it does (server::Migration).
  void migrate(size_t client);
  // The client's connection breaks and it makes a new one, which reaches a server before the old one's end does: that
  // session goes on for `late`, with nobody at the other end.
  void overtake(size_t client, Duration late);
  // Nothing moves between client and server until `end`.
  void stall(size_t client, Time end);
  void changeRequest(size_t client, const proto::ViewRequest& request) { clients_[client]->viewer.setRequest(request); }
  // From now on nothing is changed on its way. Connections with changed messages are cut.
  void stopCorruption();
  const std::shared_ptr<const server::World>& serverWorld() const { return world_; }
  // It reaches a new server, with the same scene or another.
  void connectAgain(size_t client, std::shared_ptr<const terrain::Scene> scene = nullptr);
  // Runs until `end` on the server's clock. 60 frames a second at each client.
  void run(Time end);

  // Called for each frame that shows something.
  std::function<void(size_t client, const client::FrameView&, Time now_client)> on_frame;
  // Called for each keyframe that a client has taken.
  std::function<void(size_t client, const ArrivedKeyframe&)> on_keyframe;

  // Called after each step with the processor time that it really took: how prices are measured. If it is empty, as in
  // every experiment, no clock is read.
  std::function<void(const StepWork&, double seconds)> on_step;

  const client::Viewer& viewer(size_t i) const { return clients_[i]->viewer; }
  const server::Session& session(size_t i) const { return clients_[i]->live.session; }
  // Connections of the client that its server ended, for another one to go on.
  uint64_t migrations(size_t i) const { return clients_[i]->migrations; }
  // A fingerprint of every byte that has arrived at a client.
  uint64_t bytesHash(size_t i) const { return clients_[i]->hash.value(); }
  const Traffic& traffic(size_t i) const { return clients_[i]->traffic; }
  // Broken laws, in words; empty if all is well.
  const std::vector<std::string>& complaints() const { return complaints_; }
  // The same, a line each.
  std::string report() const;

 private:
  // The server's end of a connection, and the links.
  struct Connection {
    Connection(const ClientOptions& o, std::shared_ptr<const server::World> world,
               const server::SessionOptions& session_options, uint64_t seed)
        : session(std::move(world), session_options), up(o.up, seed), down(o.down, seed + 1) {}
    server::Session session;
    Link up, down;
    bool waits_for_drain = false;
    bool has_greeted = false;
    server::Migration migration;
    bool has_left = false;  // the server has ended it, and the client has not heard of that
    // The server's, by keyframe, until the client has it.
    struct Sent {
      proto::Section section;
      std::vector<proto::KnownPage> known;
      StepWork work;
      Duration computed;
    };
    std::map<uint32_t, Sent> sections;
  };
  // One whose client is gone, which the server does not know until `end`.
  struct Abandoned {
    Connection connection;
    Time end;
    uint64_t keyframes;  // when the client left
  };
  struct Client {
    Client(const ClientOptions& o, std::shared_ptr<const server::World> world,
           const server::SessionOptions& session_options, uint64_t seed)
        : options(o), viewer(o.request), live(o, std::move(world), session_options, seed) {}
    ClientOptions options;
    client::Viewer viewer;
    Connection live;
    std::deque<Abandoned> abandoned;
    Time next_frame;
    bool path_announced = false;
    bool is_connected = true;
    std::optional<Time> connects_at;  // after it was migrated
    Rng chance{0};
    std::optional<Time> cut_at;  // after a message was changed on its way
    bool has_mesh = false, scene_changed = false, was_corrupted = false;
    uint64_t connections = 1, migrations = 0;
    Fnv1a hash;
    Traffic traffic;
    proto::PoseMemory poses_counted;
    proto::KeyframeMemory keyframes_counted;
  };

  std::optional<Time> nextEvent(const Client& c) const;
  void handle(Client& c, size_t index, Time now);
  static std::optional<Time> nextEvent(const Connection& c, Time now);
  // False if the session refuses what it has received.
  bool drive(Client& client, Connection& c, Time now);
  void serve(Client& client, Connection& c, Time now);
  void leaveForAnother(Connection& c, Time now);
  void endAbandoned(Client& c, Time now);
  void receive(Client& c, size_t index, Time now);
  void keep(Connection& c, Time now, const StepWork& work, Duration spent);
  void compare(const Client& c, uint32_t keyframe, const Connection::Sent& sent);
  void frame(Client& c, size_t index, Time now);
  void flush(Client& c, Time now);
  bool corrupts(Client& c, Time now);
  void lose(Client& c);
  void renew(Client& c);
  static void countDown(Client& c, const Bytes& message);
  static void countUp(Client& c, const Bytes& message);
  void complain(const std::string& what) { complaints_.push_back(what); }

  std::shared_ptr<const server::World> world_;
  server::SessionOptions options_;
  ComputeTime compute_time_;
  Laws laws_ = Laws::kChecked;
  uint64_t seed_;
  Time now_;
  server::SessionScratch scratch_;
  std::vector<std::unique_ptr<Client>> clients_;
  std::vector<std::string> complaints_;
};

}  // namespace foreland::sim
