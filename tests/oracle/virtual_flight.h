// A flight of the player over a small scene, and its truth: player, the server's session and the oracle together, in
// virtual time over a link of 20 ms, no sockets.
#pragma once

#include <deque>
#include <memory>
#include <utility>
#include <vector>

#include "apps/exact_sections.h"
#include "client/fly/player.h"
#include "oracle/flight_truth.h"
#include "oracle/scene_truth.h"
#include "server/session/session.h"
#include "tests/support/scene.h"
#include "tests/world/ring_of_objects.h"

namespace foreland::oracle {

inline constexpr Duration kLink = Duration::milliseconds(20), kTick = Duration::milliseconds(1);

struct Post {
  Time arrival;
  Bytes message;
};

inline std::shared_ptr<const terrain::Scene> alps() {
  static const auto scene = test::makeScene(180, 150, 3, proto::FrameKind::kGeographic);
  return scene;
}

inline client::PlayerOptions tourOptions(proto::Strategy strategy) {
  client::PlayerOptions o{.request = {}, .tour = "survey", .track = nullptr, .track_options = {}, .seconds = 4};
  o.request.lens = {.width_px = 640, .height_px = 360};
  o.request.strategy = strategy;
  o.request.predictor = proto::Predictor::kKnownPath;
  o.knowledge = client::PathKnowledge::kAnnounced;
  return o;
}

// Drives the player to its end, or until it fails.
inline Status fly(client::Player& player, server::Session& session) {
  server::SessionScratch scratch;
  std::deque<Post> up, down;
  std::vector<Bytes> sent;
  for (Time now; player.phase() != client::Player::Phase::kDone && now < Time::seconds(60); now = now + kTick) {
    for (; !up.empty() && up.front().arrival <= now; up.pop_front())
      if (Status s = session.receive(up.front().message, now); !s.ok())
        down.push_back({now + kLink, proto::encode(proto::Refusal{s.error().message})});
    if (const auto due = session.due(); due && due->release <= now) {
      session.step(now, scratch, sent);
      for (Bytes& message : sent) down.push_back({now + kLink, std::move(message)});
      sent.clear();
      session.onDrained(now);
    }
    for (; !down.empty() && down.front().arrival <= now; down.pop_front())
      if (Status s = player.receive(down.front().message, now); !s.ok()) return s;
    if (now.us % Duration::milliseconds(16).us == 0)
      if (Status s = player.frame(now); !s.ok()) return s;
    for (Bytes message; player.takeOutgoing(message);) up.push_back({now + kLink, std::move(message)});
  }
  return {};
}

struct Flight {
  client::Player player;
  Status status;
};

inline Flight flown(const client::PlayerOptions& options, server::SceneObjects objects = {}) {
  Flight flight{client::Player(options), {}};
  server::Session session(std::make_shared<server::World>(alps(), std::move(objects)), {});
  flight.status = fly(flight.player, session);
  return flight;
}

inline FlightTruth measured(const client::Player& player, const FlightTruthOptions& options,
                            const server::SceneObjects& objects = {}) {
  SceneOracle oracle(truthOf(alps()), objectsTruth(objects.set, objects.nodes));
  return measureFlight(player.log(), oracle, options);
}

inline FlightTruth measured(const client::Player& player, const server::SceneObjects& objects = {}) {
  return measured(player, {.frame_every = 20, .sections = apps::exactSectionsOf(alps())}, objects);
}

}  // namespace foreland::oracle
