// A session with a server in a thread of its own: the connection, which is made anew when it is lost, the viewer, and
// its meshes. The host's thread tells it what to do and takes what has come; neither waits for the other. Decoding and
// meshes are so kept from the thread that draws, as the page's worker keeps them (client/js/src/worker).
//
// A server that is lost is tried again after a wait that grows from 0.5 to 8 s, at random, so that the viewers of one
// server do not all come in one instant; one that hands its viewers over, at once. A session that the server refuses
// is not tried again by itself.
#pragma once

#include <condition_variable>
#include <mutex>
#include <stop_token>
#include <string>
#include <thread>
#include <vector>

#include "client/c/session_loop.h"

namespace foreland::client {

// Of the clock that hosts and sessions share: since the first call in the process.
Time sessionNow();

class Session {
 public:
  explicit Session(SessionOptions options);
  // Ends the connection and the thread, as soon as the system lets go of a host's name that it looks up.
  ~Session() = default;
  Session(const Session&) = delete;
  Session& operator=(const Session&) = delete;

  // What the host's thread calls. A frame takes the place of one that the session has not looked at.
  void tell(ToSession message);
  // What has come since the last call, the oldest first; `out` is emptied before.
  void take(std::vector<FromSession>& out);
  // Until something has come, at most so long. Whether something has.
  bool wait(std::chrono::milliseconds longest);

 private:
  void post(FromSession message);
  void run(const std::stop_token& stop);
  void loop(const std::stop_token& stop);
  void takeTold(const std::stop_token& stop, const SessionLoop& loop, std::vector<ToSession>& told);
  bool isToRun(const SessionLoop& loop);

  const SessionOptions options_;
  std::mutex mutex_;
  std::condition_variable_any told_or_stopped_, has_posted_;
  std::vector<ToSession> told_;
  std::vector<FromSession> posted_;
  std::shared_ptr<WebSocketClient> running_;  // the connection, to wake it; the thread's own otherwise
  std::jthread thread_;                       // the last member: it ends first
};

}  // namespace foreland::client
