// ViewerConnection is one viewer's WebSocket. It receives whole messages, and sends whole messages in order. The class
// is private to server/net and runs on the I/O thread; workers reach it only through its outlet, which posts to that
// thread.
#pragma once

#include <boost/beast/core/flat_buffer.hpp>
#include <boost/beast/websocket/rfc6455.hpp>
#include <cstdint>
#include <deque>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "base/bytes.h"
#include "base/time.h"
#include "server/net/context.h"
#include "server/session/migration.h"
#include "transport/transport.h"
#include "transport/web_socket.h"

namespace foreland::server {

using transport::UpgradeRequest;

class ViewerConnection : public std::enable_shared_from_this<ViewerConnection> {
 public:
  ViewerConnection(transport::Transport stream, ConnectionCount count, Pass pass, size_t scene, ServerContext& context);
  ~ViewerConnection();

  // Takes over the socket and begins the WebSocket handshake. An exception in accept(), leave(), migrate(), check() or
  // a handler ends this viewer's connection, and no other.
  void accept(UpgradeRequest request);

  // Completes the message that is being sent, sends a Refusal with `message`, then closes the connection. Other
  // messages that wait are not sent.
  void refuse(RefusedFor reason, const std::string& message);

  // Closes the connection by a close frame that carries `reason`. Messages that wait are not sent.
  void leave(boost::beast::websocket::close_code code, const std::string& reason);

  // Begins to migrate the viewer: once Migration says that it is time, the viewer is asked to connect again at once and
  // to resume.
  void migrate();
  bool isMigrating() const { return migration_.isAsked(); }

  // What it takes of one worker's time, over some seconds, and when it came.
  double cost() const { return actor_ ? actor_->cost() : 0; }
  Time openedAt() const { return opened_at_; }

  // Closes the connection if the viewer sends nothing, reads nothing, or does not answer a close frame in time, if its
  // token has expired, or if its session failed. Must be called now and then, since the connection has no timer.
  // Handshakes have a timeout of their own.
  void check(Time now);

 private:
  struct Outgoing {
    Bytes message;
    bool ends_batch = false;
  };
  enum class State : uint8_t { kAccepting, kOpen, kFlushing, kClosing, kGone };

  template <class Work>
  void orGiveUp(const Work& work) noexcept;
  void giveUp() noexcept;
  void begin(UpgradeRequest request);
  void checkOpen(Time now);
  bool hasExpired() const;
  void onAccept(boost::beast::error_code error);
  Outlet makeOutlet();
  void read();
  void onRead(boost::beast::error_code error);
  void deliver();
  void send(std::vector<Bytes> batch);
  void write();
  void onWritten(boost::beast::error_code error, size_t bytes);
  void startClosing(State state, boost::beast::websocket::close_reason reason);
  void sendCloseFrame();
  void leaveForAnother();
  void leaveSilent(const std::string& reason);
  void cut() noexcept;
  void countQueues();
  bool drainsTooSlowly(Time now) const;
  void finish(const std::string& why);

  ServerContext& context_;
  ConnectionCount count_;
  const Pass pass_;
  const size_t scene_;  // that is shown
  transport::WebSocket stream_;
  std::string peer_;
  std::shared_ptr<SessionActor> actor_;  // The pointer is null until the handshake ends, and once the viewer is gone.
  std::shared_ptr<ViewerBytes> bytes_;   // The pointer is null until the handshake ends.
  State state_ = State::kAccepting;
  boost::beast::websocket::close_reason close_reason_;
  Time close_by_;  // A connection that is flushing or closing is cut after this time.

  boost::beast::flat_buffer read_buffer_;
  Time heard_at_;  // The viewer last sent bytes at this time.
  Time opened_at_, message_begun_at_;
  bool has_greeted_ = false;  // The viewer has sent a whole message.
  Migration migration_;

  std::deque<Outgoing> outbox_;
  size_t outbox_bytes_ = 0;
  size_t written_of_first_ = 0;
  bool is_writing_ = false;
  Time progress_at_;  // A piece of a message was last begun or taken by the system at this time.
  Time busy_since_;   // The outbox was last empty at this time.
  uint64_t written_since_ = 0;
  int64_t counted_bytes_ = 0;  // bytes_ counts so many bytes of the read buffer and the outbox.
  uint64_t batches_sent_ = 0;
};

// Makes a ViewerConnection of a socket whose HTTP request asks for WebSocket.
void acceptViewer(transport::Transport stream, ConnectionCount count, Pass pass, size_t scene, UpgradeRequest request,
                  ServerContext& context);

}  // namespace foreland::server
