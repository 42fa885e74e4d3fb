// What a session's thread does (session.h): a viewer and its connection. One owner, that thread.
#pragma once

#include <chrono>
#include <deque>
#include <functional>
#include <memory>
#include <optional>
#include <random>
#include <stop_token>
#include <string>
#include <unordered_map>
#include <vector>

#include "client/c/messages.h"
#include "client/fly/net/web_socket_client.h"
#include "client/ground_supply.h"
#include "client/newest_mesh.h"

namespace foreland::client {

struct SessionOptions {
  std::string url;
  WebSocketClient::Options connection{};
  proto::ViewRequest request{};
  Blend blend = Blend::kKeyframe;
  bool has_meshes = true;
};

class SessionLoop {
 public:
  using Post = std::function<void(FromSession)>;

  // `stop` ends connecting.
  SessionLoop(SessionOptions options, const std::stop_token& stop, Post post);

  void handle(ToSession message);
  // Tries to connect if it is time to.
  void connectIfDue();
  // Sends and receives until the connection is woken, or for some time.
  void run();
  // Closes the connection.
  void end();

  const std::shared_ptr<WebSocketClient>& connection() const { return connection_; }
  // How long there is nothing to do without a connection.
  std::chrono::milliseconds idle() const;

 private:
  // A viewer, and what belongs to it.
  struct Held {
    explicit Held(const proto::ViewRequest& request) : viewer(request) {}
    Viewer viewer;
    NewestMesh newest{viewer};
    GroundSupply ground{};
  };
  // Exact heights are asked for one question at a time: a server refuses a viewer that asks for more than it reads.
  struct HeightsQuestion {
    uint64_t question;  // 0: not wanted any more
    std::vector<glm::dvec2> positions;
  };
  enum class Next : uint8_t { kAtTime, kWhenSeen, kWhenTold };  // attempt to connect

  void on(told::Frame message);
  void on(told::Jump message);
  void on(told::Request message);
  void on(told::SetBlend message);
  void on(told::Clock message);
  void on(told::Path message);
  void on(told::Token message);
  void on(told::Seen message);
  void on(told::Reconnect message);
  void on(told::Redraw message);
  void on(told::Heights message);
  void on(told::Sight message);
  void on(told::Viewshed message);
  void on(told::Cancel message);

  void makeViewer();
  void begin();
  Status receive(ByteSpan message);
  void greet();
  void takeReplies();
  void takeViewsheds();
  void askHeights();
  void sendMesh();
  void sendOutgoing();
  void applyBlend();
  void lose(const std::string& reason, LostBy by);
  void waitAndReconnect(const std::string& reason);
  void leaveUnanswered(const std::string& reason);
  void unanswered(uint64_t question, const std::string& reason);

  SessionOptions options_;
  Post post_;
  std::optional<Held> held_;
  std::optional<proto::SceneClock> clock_;
  std::optional<proto::Path> path_;

  std::shared_ptr<WebSocketClient> connection_;
  bool is_greeted_ = false;   // on this connection
  bool was_greeted_ = false;  // on any
  bool has_refused_ = false;
  size_t largest_bytes_ = 0;  // of the messages of this connection
  Next next_ = Next::kAtTime;
  Time next_at_;  // of kAtTime
  Duration wait_;
  bool is_seen_ = true;
  std::minstd_rand random_{std::random_device{}()};

  std::vector<uint32_t> untaken_;  // versions of meshes that were made
  bool is_update_whole_ = false;   // the next one
  uint32_t redraws_ = 0;

  std::deque<HeightsQuestion> heights_;
  std::optional<uint32_t> asked_heights_;                  // the reply's number
  std::unordered_map<uint32_t, uint64_t> sights_;          // questions by the reply's number
  std::optional<std::pair<uint32_t, uint64_t>> viewshed_;  // likewise
};

}  // namespace foreland::client
