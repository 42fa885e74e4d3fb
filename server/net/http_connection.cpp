#include "server/net/http_connection.h"

#include <boost/asio/write.hpp>
#include <boost/beast/core/flat_buffer.hpp>
#include <boost/beast/http/empty_body.hpp>
#include <boost/beast/http/message.hpp>
#include <boost/beast/http/parser.hpp>
#include <boost/beast/http/read.hpp>
#include <boost/beast/http/string_body.hpp>
#include <boost/beast/http/write.hpp>
#include <boost/beast/websocket/rfc6455.hpp>
#include <chrono>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <variant>

#include "server/net/http/scene_paths.h"
#include "server/net/viewer_connection.h"
#include "transport/transport.h"

namespace foreland::server {
namespace beast = boost::beast;
using transport::Transport;
namespace http = beast::http;
namespace {

constexpr const char* kTooManyFromThere = "There are too many connections from your address. Try again in a while.";
constexpr uint64_t kMaxBodyBytes = 4u << 10;  // no request here needs a body
constexpr size_t kReplyPieceBytes = 32u << 10;
constexpr size_t kMaxIgnoredBytes = 1u << 20;  // of a request that was refused before it ended

std::string_view view(beast::string_view text) { return {text.data(), text.size()}; }

// All lines of that name as one list, in their order: a proxy may add a line of its own below what a client made up.
std::string listOf(const http::request<http::string_body>& request, beast::string_view name) {
  std::string list;
  const auto [begin, end] = request.equal_range(name);
  for (auto line = begin; line != end; ++line) list.append(list.empty() ? "" : ",").append(view(line->value()));
  return list;
}

class HttpConnection : public std::enable_shared_from_this<HttpConnection> {
 public:
  HttpConnection(boost::asio::ip::tcp::socket socket, Admission admission, ServerContext& context)
      : context_(context),
        admission_(admission),
        count_(context, admission, socket),
        from_(addressOf(socket)),
        tls_(admission == Admission::kMetrics ? nullptr : context.tls),
        stream_(tls_ ? Transport(beast::tcp_stream(std::move(socket)), *tls_)
                     : Transport(beast::tcp_stream(std::move(socket)))) {}

  void start() {
    if (!stream_.isTls()) return read();
    allowMoreTime();
    stream_.handshakeAsServer([self = shared_from_this()](beast::error_code error) {
      if (!error) self->read();
    });
  }

 private:
  void allowMoreTime() {
    stream_.next_layer().expires_after(std::chrono::microseconds(context_.options.http_timeout.us));
  }

  void read() {
    parser_.emplace();
    parser_->header_limit(static_cast<uint32_t>(context_.options.max_header_bytes));
    parser_->body_limit(kMaxBodyBytes);
    allowMoreTime();
    http::async_read(stream_, buffer_, *parser_,
                     [self = shared_from_this()](beast::error_code error, size_t) { self->onRead(error); });
  }

  void onRead(beast::error_code error) {
    if (error == http::error::end_of_stream) return shutDown();
    if (error && error.category() == make_error_code(http::error::bad_version).category()) return refuse(error);
    if (error) return;  // reset or timed out; the socket is closed when this object is destroyed
    const auto& request = parser_->get();
    if (admission_ == Admission::kReserve && !isForOperators(view(request.target())))
      return refuse({503, RefusedFor::kFull, "The server is full. Try again in a while"});
    if (isFullFor(request)) return refuse({503, RefusedFor::kAddress, kTooManyFromThere});
    const bool is_upgrade = beast::websocket::is_upgrade(request);
    if (admission_ != Admission::kMetrics && is_upgrade) return letIn();
    noteFleet(request);
    HttpReply reply = replyTo({.method = view(request.method_string()),
                               .target = view(request.target()),
                               .if_none_match = view(request[http::field::if_none_match]),
                               .accept_encoding = view(request[http::field::accept_encoding]),
                               .range = view(request[http::field::range]),
                               .if_range = view(request[http::field::if_range]),
                               .lost_its_upgrade = !view(request[http::field::sec_websocket_key]).empty()},
                              admission_ == Admission::kMetrics ? context_.metrics_site : context_.site);
    if (reply.status == 426 && isForViewers(view(request.target()), context_.site))
      reply = viewersReply(std::move(reply));
    write(reply, request.method() == http::verb::head, request.keep_alive());
  }

  // What a balancer says of the fleet with its checks. It takes these fields from what it passes on.
  void noteFleet(const http::request<http::string_body>& request) {
    const auto state = request.find("X-Haproxy-Server-State");
    if (state == request.end() || view(request.target()) != "/readyz" || !context_.gate.isTrusted(from_)) return;
    context_.fleet.note(view(state->value()), view(request["X-Foreland-Servers"]), context_.clock());
  }

  // Whether there are as many connections from the address that a trusted proxy names as may be.
  bool isFullFor(const http::request<http::string_body>& request) {
    if (admission_ == Admission::kMetrics || !context_.gate.isTrusted(from_)) return false;
    const std::string listed = listOf(request, "X-Forwarded-For");
    const std::string client = context_.gate.clientOf(from_, listed.empty() ? listOf(request, "Forwarded") : listed);
    return client != from_ && count_.countFor(client) >= context_.options.max_connections_per_address;
  }

  // A viewer, if it may come.
  void letIn() {
    auto pass = admit();
    if (const auto* rejection = std::get_if<Rejection>(&pass)) return refuse(*rejection);
    const auto scene = sceneToFly(view(parser_->get().target()), context_.site.scenes);
    if (!scene) return refuse({404, RefusedFor::kScene, noSuchScene(context_.site)});
    context_.metrics.countHttpReply(101);
    acceptViewer(std::move(stream_), std::move(count_), std::get<Pass>(std::move(pass)), *scene, parser_->release(),
                 context_);
  }

  std::variant<Pass, Rejection> admit() {
    if (context_.is_draining)
      return Rejection{503, RefusedFor::kStopping, "The server stops. Connect again, to another server."};
    const auto& request = parser_->get();
    const auto now = std::chrono::system_clock::now().time_since_epoch();
    return context_.gate.admit({.origin = view(request[http::field::origin]),
                                .host = view(request[http::field::host]),
                                .target = view(request.target()),
                                .authorization = view(request[http::field::authorization])},
                               std::chrono::duration_cast<std::chrono::seconds>(now).count());
  }

  // A page cannot read why its WebSocket was refused, so it asks again without: what it is told is what the WebSocket
  // was, and `otherwise` if that would have been let in.
  HttpReply viewersReply(HttpReply otherwise) {
    const auto pass = admit();
    const auto* rejection = std::get_if<Rejection>(&pass);
    HttpReply reply = rejection ? textReply(rejection->status, rejection->why) : std::move(otherwise);
    reply.readable_by = ReadableBy::kAnyOrigin;
    return reply;
  }

  void refuse(const Rejection& rejection) {
    context_.metrics.count(rejection.reason);
    write(textReply(rejection.status, rejection.why), false, false);
  }

  void refuse(beast::error_code error) {
    context_.log(Severity::kDebug, "refused what is no request: " + error.message());
    ignores_rest_ = true;
    if (error == http::error::header_limit)
      return write(textReply(431, "The fields of the request have more than " +
                                      std::to_string(context_.options.max_header_bytes >> 10) +
                                      " KiB, cookies included; --max-header-kib of the server lets in longer ones."),
                   false, false);
    write(textReply(400,
                    "This is an HTTP and WebSocket server; the request was not understood (" + error.message() + ")."),
          false, false);
  }

  void write(const HttpReply& reply, bool head_only, bool keep_alive) {
    context_.metrics.countHttpReply(reply.status);
    body_ = reply.body;
    unsent_ = head_only ? std::string_view() : reply.content();
    response_ = {};
    response_.version(11);
    response_.result(reply.status);
    setFields(reply);
    response_.keep_alive(keep_alive);
    if (reply.status != 304) response_.content_length(reply.content().size());
    allowMoreTime();
    http::async_write(stream_, response_, [self = shared_from_this(), keep_alive](beast::error_code error, size_t) {
      if (!error) self->writeBody(keep_alive);
    });
  }

  void setFields(const HttpReply& reply) {
    response_.set(http::field::server, "foreland");
    response_.set(http::field::content_type, reply.content_type);
    response_.set(http::field::cache_control, reply.cache_control);
    for (const auto& [name, value] : kRules) response_.set(name, value);
    if (isRunByBrowsers(reply.content_type))
      for (const auto& [name, value] : kPageRules) response_.set(name, value);
    if (!reply.etag.empty()) response_.set(http::field::etag, reply.etag);
    if (!reply.etag.empty()) response_.set(http::field::accept_ranges, "bytes");
    if (!reply.encoding.empty()) response_.set(http::field::content_encoding, reply.encoding);
    if (!reply.content_range.empty()) response_.set(http::field::content_range, reply.content_range);
    if (reply.status == 401) response_.set(http::field::www_authenticate, "Bearer");
    if (reply.status == 405) response_.set(http::field::allow, "GET, HEAD");
    if (reply.status == 503) response_.set(http::field::retry_after, "5");
    if (reply.status == 426) response_.set(http::field::upgrade, "websocket");
    if (!reply.location.empty()) response_.set(http::field::location, reply.location);
    setSharing(reply);
  }

  // With which pages of other origins browsers share the reply, also those that may load nothing else
  // (Cross-Origin-Embedder-Policy).
  void setSharing(const HttpReply& reply) {
    std::string varies = reply.varies ? "Accept-Encoding" : "";
    if (reply.readable_by == ReadableBy::kAnyOrigin) response_.set(http::field::access_control_allow_origin, "*");
    if (reply.readable_by == ReadableBy::kAllowedOrigins) {
      const std::string origin = context_.gate.sharesWith(view(parser_->get()[http::field::origin]));
      if (origin != "*") varies += varies.empty() ? "Origin" : ", Origin";
      if (!origin.empty()) response_.set(http::field::access_control_allow_origin, origin);
      if (!origin.empty()) response_.set("Cross-Origin-Resource-Policy", "cross-origin");
    }
    if (!varies.empty()) response_.set(http::field::vary, varies);
  }

  // Piece by piece, each with a deadline of its own: who reads slowly gets large files, too.
  void writeBody(bool keep_alive) {
    if (unsent_.empty()) return keep_alive ? read() : shutDown();
    const std::string_view piece = unsent_.substr(0, kReplyPieceBytes);
    unsent_.remove_prefix(piece.size());
    allowMoreTime();
    boost::asio::async_write(stream_, boost::asio::buffer(piece),
                             [self = shared_from_this(), keep_alive](beast::error_code error, size_t) {
                               if (!error) self->writeBody(keep_alive);
                             });
  }

  void shutDown() {
    if (stream_.isTls()) {
      allowMoreTime();
      return stream_.shutDownTls([self = shared_from_this()](beast::error_code) {});
    }
    beast::error_code ignored;
    stream_.next_layer().socket().shutdown(boost::asio::ip::tcp::socket::shutdown_send, ignored);
    if (ignores_rest_) ignoreRest(kMaxIgnoredBytes);
  }

  // A socket that is closed while it has bytes to read resets the connection, which may lose the reply on its way.
  void ignoreRest(size_t most) {
    buffer_.clear();
    stream_.async_read_some(buffer_.prepare(kReplyPieceBytes),
                            [self = shared_from_this(), most](beast::error_code error, size_t bytes) {
                              if (!error && bytes < most) self->ignoreRest(most - bytes);
                            });
  }

  ServerContext& context_;
  const Admission admission_;
  ConnectionCount count_;
  const std::string from_;  // the other end's address
  const std::shared_ptr<boost::asio::ssl::context> tls_;
  Transport stream_;
  beast::flat_buffer buffer_;
  std::optional<http::request_parser<http::string_body>> parser_;
  std::shared_ptr<const std::string> body_;
  std::string_view unsent_;                    // of the body
  bool ignores_rest_ = false;                  // of the request
  http::response<http::empty_body> response_;  // without it
};

}  // namespace

void serveHttp(boost::asio::ip::tcp::socket socket, Admission admission, ServerContext& context) {
  std::make_shared<HttpConnection>(std::move(socket), admission, context)->start();
}

}  // namespace foreland::server
