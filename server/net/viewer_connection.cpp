#include "server/net/viewer_connection.h"

#include <fmt/format.h>

#include <algorithm>
#include <boost/asio/post.hpp>
#include <chrono>
#include <utility>

#include "base/printable.h"
#include "proto/message/message.h"

namespace foreland::server {
namespace beast = boost::beast;
namespace websocket = beast::websocket;
namespace {

// Large messages are sent in pieces, so that a slow link can be distinguished from one that has stopped.
constexpr size_t kPieceBytes = 64u << 10;
// A read buffer that has grown beyond this, for a path, is freed.
constexpr size_t kKeptBufferBytes = 64u << 10;
constexpr Duration kCloseGrace = Duration::seconds(2);
constexpr size_t kMaxReasonBytes = 120;  // of a close frame
// The slowest that a viewer may read what waits for it, over as long as it may be silent.
constexpr double kMinBytesPerSecond = 1000;

constexpr size_t kMaxLoggedBytes = 300;

websocket::close_reason reasonOf(websocket::close_code code, const std::string& text) {
  const std::string_view cut = cutText(text, kMaxReasonBytes);
  return {code, beast::string_view(cut.data(), cut.size())};
}

// Its address and port, after that of whom a proxy connects, if one does.
std::string peerOf(const beast::tcp_stream& stream, const std::string& client) {
  beast::error_code error;
  const auto endpoint = stream.socket().remote_endpoint(error);
  if (error) return "an unknown address";
  const std::string address = endpoint.address().to_string();
  return fmt::format("{}{}:{}", client == address ? "" : client + " by ", address, endpoint.port());
}

}  // namespace

void acceptViewer(transport::Transport stream, ConnectionCount count, Pass pass, size_t scene, UpgradeRequest request,
                  ServerContext& context) {
  std::make_shared<ViewerConnection>(std::move(stream), std::move(count), std::move(pass), scene, context)
      ->accept(std::move(request));
}

ViewerConnection::ViewerConnection(transport::Transport stream, ConnectionCount count, Pass pass, size_t scene,
                                   ServerContext& context)
    : context_(context), count_(std::move(count)), pass_(std::move(pass)), scene_(scene), stream_(std::move(stream)) {}

ViewerConnection::~ViewerConnection() {
  if (bytes_) bytes_->add(-counted_bytes_);
}

void ViewerConnection::countQueues() {
  const auto bytes = static_cast<int64_t>(read_buffer_.size() + outbox_bytes_);
  bytes_->add(bytes - counted_bytes_);
  counted_bytes_ = bytes;
}

bool ViewerConnection::drainsTooSlowly(Time now) const {
  const Duration busy = now - busy_since_;
  return is_writing_ && busy > context_.options.idle_timeout &&
         static_cast<double>(written_since_) < kMinBytesPerSecond * busy.toSeconds();
}

template <class Work>
void ViewerConnection::orGiveUp(const Work& work) noexcept {
  try {
    work();
  } catch (...) {  // out of memory, say
    ++context_.metrics.failures;
    giveUp();
  }
}

// Needs no memory. What is pending fails then, and finds the viewer gone.
void ViewerConnection::giveUp() noexcept {
  state_ = State::kGone;
  if (actor_) actor_->close();
  actor_.reset();
  cut();  // the outbox stays: a write may still point into it
  context_.viewers.erase(shared_from_this());
}

void ViewerConnection::accept(UpgradeRequest request) {
  orGiveUp([&] { begin(std::move(request)); });
}

void ViewerConnection::begin(UpgradeRequest request) {
  beast::tcp_stream& socket = stream_.transport().next_layer();
  socket.expires_never();  // from here on check() enforces the timeouts
  peer_ = peerOf(socket, count_.address());
  stream_.setLimits({.handshake_timeout = std::chrono::microseconds(context_.options.http_timeout.us),
                     .max_message_bytes = proto::kMaxClientMessageBytes});
  context_.viewers.insert(shared_from_this());  // before the handshake ends, so that a stop of the server closes it too
  auto shared = std::make_shared<UpgradeRequest>(std::move(request));
  stream_.accept(*shared, "foreland", [self = shared_from_this(), shared](beast::error_code error) {
    self->orGiveUp([&] { self->onAccept(error); });
  });
}

void ViewerConnection::onAccept(beast::error_code error) {
  if (error || state_ == State::kGone) return giveUp();
  state_ = State::kOpen;
  heard_at_ = progress_at_ = opened_at_ = message_begun_at_ = context_.clock();
  actor_ = context_.host.open(makeOutlet(), pass_.token.section_nodes, scene_);
  bytes_ = actor_->bytes();
  context_.log(Severity::kInfo, "viewer " + peer_ + " is here");
  read();
  if (close_reason_.code != websocket::close_code::none)
    leave(static_cast<websocket::close_code>(close_reason_.code), close_reason_.reason.c_str());
}

Outlet ViewerConnection::makeOutlet() {
  const std::weak_ptr<ViewerConnection> weak = weak_from_this();
  auto& io = context_.io;
  const auto post = [weak, &io](auto action) {
    boost::asio::post(io, [weak, action = std::move(action)]() mutable {
      if (const auto self = weak.lock()) self->orGiveUp([&] { action(*self); });
    });
  };
  return {.send =
              [post](std::vector<Bytes> batch) {
                post([batch = std::move(batch)](ViewerConnection& self) mutable { self.send(std::move(batch)); });
              },
          .refuse =
              [post](std::string message) {
                post([message = std::move(message)](ViewerConnection& self) {
                  self.refuse(RefusedFor::kMessage, message);
                });
              }};
}

void ViewerConnection::read() {
  stream_.readSome(read_buffer_, [self = shared_from_this()](beast::error_code error, size_t) {
    self->orGiveUp([&] { self->onRead(error); });
  });
}

void ViewerConnection::onRead(beast::error_code error) {
  if (error)
    return finish(migration_.isAsked()                ? "was handed over"
                  : error == websocket::error::closed ? "left"
                                                      : "was lost: " + error.message());
  heard_at_ = context_.clock();
  if (stream_.isMessageDone()) {
    has_greeted_ = true;
    message_begun_at_ = heard_at_;
    deliver();
  }
  countQueues();
  if (read_buffer_.size() > kKeptBufferBytes)
    if (const Status room = bytes_->checkRoomFor(0); !room.ok()) refuse(RefusedFor::kQueues, room.error().message);
  read();  // while closing too, to receive the viewer's close frame
}

void ViewerConnection::deliver() {
  const auto* data = static_cast<const uint8_t*>(read_buffer_.data().data());
  Bytes message(data, data + read_buffer_.size());
  read_buffer_.clear();
  if (read_buffer_.capacity() > kKeptBufferBytes) read_buffer_.shrink_to_fit();
  countQueues();
  if (state_ != State::kOpen) return;
  context_.metrics.bytes_up += message.size();
  ++context_.metrics.messages_up;
  if (stream_.gotText()) return refuse(RefusedFor::kMessage, "messages are binary here; this one was text");
  if (const Status status = actor_->deliver(std::move(message)); !status.ok())
    refuse(RefusedFor::kQueues, status.error().message);
}

void ViewerConnection::send(std::vector<Bytes> batch) {
  if (state_ != State::kOpen) return;
  if (outbox_.empty()) {
    busy_since_ = context_.clock();
    written_since_ = 0;
  }
  for (Bytes& message : batch) {
    outbox_bytes_ += message.size();
    outbox_.push_back({.message = std::move(message)});
  }
  outbox_.back().ends_batch = true;
  countQueues();
  if (outbox_.size() > context_.options.max_unread_messages)
    return refuse(RefusedFor::kUnread, "you ask for more than you read; the connection cannot carry it");
  write();
}

void ViewerConnection::write() {
  if (is_writing_ || outbox_.empty()) return;
  const Bytes& message = outbox_.front().message;
  const size_t left = message.size() - written_of_first_, piece = std::min(left, kPieceBytes);
  is_writing_ = true;
  progress_at_ = context_.clock();
  stream_.writeSome(piece == left ? transport::WebSocket::Piece::kLast : transport::WebSocket::Piece::kMore,
                    boost::asio::buffer(message.data() + written_of_first_, piece),
                    [self = shared_from_this(), piece](beast::error_code error, size_t) {
                      self->orGiveUp([&] { self->onWritten(error, piece); });
                    });
}

void ViewerConnection::onWritten(beast::error_code error, size_t bytes) {
  is_writing_ = false;
  if (error || state_ == State::kGone) return cut();  // the pending read then fails and calls finish()
  progress_at_ = context_.clock();
  context_.metrics.bytes_down += bytes;
  written_of_first_ += bytes;
  written_since_ += bytes;
  if (written_of_first_ == outbox_.front().message.size()) {
    if (outbox_.front().ends_batch) ++batches_sent_;
    outbox_bytes_ -= outbox_.front().message.size();
    outbox_.pop_front();
    written_of_first_ = 0;
    countQueues();
  }
  if (state_ == State::kClosing || (state_ == State::kFlushing && outbox_.empty())) return sendCloseFrame();
  if (outbox_.empty() && state_ == State::kOpen) {
    if (migration_.leavesOnceSent()) return leaveForAnother();
    actor_->sent(batches_sent_);
  }
  write();
}

void ViewerConnection::refuse(RefusedFor reason, const std::string& message) {
  if (state_ != State::kOpen) return;
  context_.metrics.count(reason);
  context_.log(Severity::kInfo, "viewer " + peer_ + " is refused: " + printable(message, kMaxLoggedBytes));
  if (!outbox_.empty()) outbox_.resize(written_of_first_ > 0 || is_writing_ ? 1 : 0);
  outbox_.push_back({.message = proto::encode(proto::Refusal{.message = message})});
  outbox_bytes_ = 0;
  for (const Outgoing& waiting : outbox_) outbox_bytes_ += waiting.message.size();
  countQueues();
  startClosing(State::kFlushing, reasonOf(websocket::close_code::policy_error, message));
  write();
}

void ViewerConnection::leave(websocket::close_code code, const std::string& reason) {
  orGiveUp([&] {
    const websocket::close_reason why = reasonOf(code, reason);
    if (state_ == State::kAccepting) close_reason_ = why;  // for onAccept
    if (state_ != State::kOpen) return;
    startClosing(State::kClosing, why);
    if (!is_writing_) sendCloseFrame();
  });
}

void ViewerConnection::migrate() {
  orGiveUp([&] {
    const Time now = context_.clock();
    migration_.ask(now);
    if (migration_.isOverdue(now, has_greeted_)) leaveForAnother();
  });
}

void ViewerConnection::leaveForAnother() {
  leave(websocket::close_code::service_restart, "the server stops; connect again at once and resume");
}

void ViewerConnection::startClosing(State state, websocket::close_reason reason) {
  state_ = state;
  close_reason_ = std::move(reason);
  close_by_ = context_.clock() + kCloseGrace;
  actor_->close();
}

// Must not be called while a piece is being written. The viewer's answer, or a failure, ends the pending read.
void ViewerConnection::sendCloseFrame() {
  state_ = State::kClosing;
  stream_.close(close_reason_, [self = shared_from_this()](beast::error_code) {});
}

void ViewerConnection::check(Time now) {
  if (state_ == State::kOpen) return orGiveUp([&] { checkOpen(now); });
  if ((state_ == State::kFlushing || state_ == State::kClosing) && now > close_by_)
    orGiveUp([&] { finish("did not answer"); });
}

void ViewerConnection::checkOpen(Time now) {
  const Duration timeout = context_.options.idle_timeout;
  if (actor_->hasFailed()) return refuse(RefusedFor::kMessage, "the server failed to serve you; connect again");
  if ((is_writing_ && now - progress_at_ > timeout) || drainsTooSlowly(now)) {
    context_.metrics.count(RefusedFor::kUnread);
    return finish(fmt::format("read nothing, or hardly anything, for {:.0f} s", timeout.toSeconds()));
  }
  if (migration_.isOverdue(now, has_greeted_)) return leaveForAnother();
  if (hasExpired()) return leave(websocket::close_code::policy_error, "your token has expired");
  if (!has_greeted_ && now - opened_at_ > context_.options.hello_timeout)
    return leaveSilent("no message for too long; connect again");
  if (read_buffer_.size() > 0 && now - message_begun_at_ > context_.options.message_timeout)
    return leaveSilent("a message does not end; connect again");
  if (now - heard_at_ > timeout) leaveSilent("no pose for too long; connect again");
}

void ViewerConnection::leaveSilent(const std::string& reason) {
  context_.metrics.count(RefusedFor::kSilent);
  leave(websocket::close_code::policy_error, reason);
}

bool ViewerConnection::hasExpired() const {
  return pass_.viewers &&
         std::chrono::system_clock::now().time_since_epoch() > std::chrono::seconds(pass_.token.expires_s);
}

void ViewerConnection::cut() noexcept { stream_.transport().next_layer().close(); }

void ViewerConnection::finish(const std::string& why) {
  if (state_ == State::kGone) return;
  context_.log(Severity::kInfo, "viewer " + peer_ + " " + why);
  giveUp();
}

}  // namespace foreland::server
