// One viewer's WebSocket: it takes whole messages and sends whole messages in order. Private to server/net. It runs on
// the I/O thread; workers reach it only through the outlet, which posts to that thread.
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
  ViewerConnection(transport::Transport stream, ConnectionCount count, Pass pass, ServerContext& context);
  ~ViewerConnection();

  // Whatever one of these and the handlers throw ends this viewer, and nothing else.
  void accept(UpgradeRequest request);

  // Completes the message that is being sent, sends a Refusal with `message`, then closes.
  void refuse(RefusedFor reason, const std::string& message);

  // Closes with a close frame that carries `reason`; messages that wait are not sent.
  void leave(boost::beast::websocket::close_code code, const std::string& reason);

  // Asks the viewer to connect again at once, and to resume, when it is time (Migration).
  void migrate();
  bool isMigrating() const { return migration_.isAsked(); }

  // To be called now and then: closes a viewer that sends nothing, reads nothing, or does not answer a close frame in
  // time, and one whose session failed. Handshakes have a timeout of their own.
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
  transport::WebSocket stream_;
  std::string peer_;
  std::shared_ptr<SessionActor> actor_;  // null unless open
  std::shared_ptr<ViewerBytes> bytes_;   // null until then
  State state_ = State::kAccepting;
  boost::beast::websocket::close_reason close_reason_;
  Time close_by_;  // while flushing or closing

  boost::beast::flat_buffer read_buffer_;
  Time heard_at_;  // when the viewer last sent bytes
  Time opened_at_, message_begun_at_;
  bool has_greeted_ = false;  // sent a whole message
  Migration migration_;

  std::deque<Outgoing> outbox_;
  size_t outbox_bytes_ = 0;
  size_t written_of_first_ = 0;
  bool is_writing_ = false;
  Time progress_at_;  // when the system last took a piece
  Time busy_since_;   // when the outbox was last empty
  uint64_t written_since_ = 0;
  int64_t counted_bytes_ = 0;  // of read buffer and outbox, in bytes_
  uint64_t batches_sent_ = 0;
};

// Takes over a socket whose HTTP request asks for WebSocket.
void acceptViewer(transport::Transport stream, ConnectionCount count, Pass pass, UpgradeRequest request,
                  ServerContext& context);

}  // namespace foreland::server
