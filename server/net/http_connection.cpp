#include "server/net/http_connection.h"

#include <boost/beast/core.hpp>
#include <boost/beast/http.hpp>
#include <boost/beast/websocket/rfc6455.hpp>
#include <chrono>
#include <memory>
#include <optional>
#include <utility>

#include "server/net/viewer_connection.h"

namespace foreland::server {
namespace beast = boost::beast;
namespace http = beast::http;
namespace {

constexpr uint32_t kMaxHeaderBytes = 8u << 10;
constexpr uint64_t kMaxBodyBytes = 4u << 10;  // no request here needs a body

std::string_view view(beast::string_view text) { return {text.data(), text.size()}; }

class HttpConnection : public std::enable_shared_from_this<HttpConnection> {
 public:
  HttpConnection(boost::asio::ip::tcp::socket socket, Admission admission, ServerContext& context)
      : context_(context), admission_(admission), count_(context, admission, socket), stream_(std::move(socket)) {}

  void read() {
    parser_.emplace();
    parser_->header_limit(kMaxHeaderBytes);
    parser_->body_limit(kMaxBodyBytes);
    stream_.expires_after(std::chrono::microseconds(context_.options.http_timeout.us));
    http::async_read(stream_, buffer_, *parser_,
                     [self = shared_from_this()](beast::error_code error, size_t) { self->onRead(error); });
  }

 private:
  void onRead(beast::error_code error) {
    if (error == http::error::end_of_stream) return shutDown();
    if (error && error.category() == make_error_code(http::error::bad_version).category()) return refuse(error);
    if (error) return;  // reset or timed out; the socket is closed when this object is destroyed
    const auto& request = parser_->get();
    if (admission_ == Admission::kReserve && !isForOperators(view(request.target())))
      return refuse(RefusedFor::kFull, "The server is full. Try again in a while");
    if (admission_ != Admission::kMetrics && beast::websocket::is_upgrade(request)) {
      if (context_.is_draining)
        return refuse(RefusedFor::kStopping, "The server stops. Connect again, to another server.");
      context_.metrics.countHttpReply(101);
      acceptViewer(std::move(stream_), std::move(count_), parser_->release(), context_);
      return;
    }
    const HttpReply reply = replyTo({.method = view(request.method_string()),
                                     .target = view(request.target()),
                                     .if_none_match = view(request[http::field::if_none_match])},
                                    admission_ == Admission::kMetrics ? context_.metrics_site : context_.site);
    write(reply, request.method() == http::verb::head, request.keep_alive());
  }

  void refuse(RefusedFor reason, const char* why) {
    context_.metrics.count(reason);
    write(textReply(503, why), false, false);
  }

  void refuse(beast::error_code error) {
    context_.log(Severity::kDebug, "closed a connection that does not speak HTTP: " + error.message());
    write(textReply(400,
                    "This is an HTTP and WebSocket server; the request was not understood (" + error.message() + ")."),
          false, false);
  }

  void write(const HttpReply& reply, bool head_only, bool keep_alive) {
    context_.metrics.countHttpReply(reply.status);
    body_ = reply.body;
    response_ = {};
    response_.version(11);
    response_.result(reply.status);
    response_.set(http::field::server, "foreland");
    response_.set(http::field::content_type, reply.content_type);
    response_.set(http::field::cache_control, reply.cache_control);
    response_.set("X-Content-Type-Options", "nosniff");
    if (!reply.etag.empty()) response_.set(http::field::etag, reply.etag);
    if (reply.status == 405) response_.set(http::field::allow, "GET, HEAD");
    if (reply.status == 503) response_.set(http::field::retry_after, "5");
    if (reply.status == 426) response_.set(http::field::upgrade, "websocket");
    response_.keep_alive(keep_alive);
    if (reply.status != 304) response_.content_length(body_->size());
    if (!head_only) response_.body() = {body_->data(), body_->size()};
    stream_.expires_after(std::chrono::microseconds(context_.options.http_timeout.us));
    http::async_write(stream_, response_, [self = shared_from_this(), keep_alive](beast::error_code error, size_t) {
      if (error) return;
      if (keep_alive)
        self->read();
      else
        self->shutDown();
    });
  }

  void shutDown() {
    beast::error_code ignored;
    stream_.socket().shutdown(boost::asio::ip::tcp::socket::shutdown_send, ignored);
  }

  ServerContext& context_;
  const Admission admission_;
  ConnectionCount count_;
  beast::tcp_stream stream_;
  beast::flat_buffer buffer_;
  std::optional<http::request_parser<http::string_body>> parser_;
  std::shared_ptr<const std::string> body_;  // which the response points into
  http::response<http::span_body<const char>> response_;
};

}  // namespace

void serveHttp(boost::asio::ip::tcp::socket socket, Admission admission, ServerContext& context) {
  std::make_shared<HttpConnection>(std::move(socket), admission, context)->read();
}

}  // namespace foreland::server
