#include "client/fly/net/web_socket_client.h"

#include <algorithm>
#include <boost/asio/connect.hpp>
#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/post.hpp>
#include <boost/asio/ssl/context.hpp>
#include <boost/asio/ssl/host_name_verification.hpp>
#include <boost/asio/steady_timer.hpp>
#include <deque>
#include <iterator>
#include <optional>
#include <string_view>

#include "base/printable.h"
#include "proto/message/message.h"
#include "transport/transport.h"
#include "transport/web_socket.h"

namespace foreland::client {

namespace asio = boost::asio;
namespace beast = boost::beast;
using boost::system::error_code;
using tcp = asio::ip::tcp;

namespace {

struct Scheme {
  std::string_view prefix;
  Security security;
  const char* port;
};
constexpr size_t kMaxSaidBytes = 400;  // that a server says of why it refuses a viewer
constexpr Scheme kSchemes[] = {{"ws://", Security::kNone, "80"},
                               {"wss://", Security::kTls, "443"},
                               {"http://", Security::kNone, "80"},
                               {"https://", Security::kTls, "443"}};

}  // namespace

Result<WebSocketUrl> parseWebSocketUrl(const std::string& url) {
  const auto refuse = [&](const std::string& why) {
    return Error{ErrorCode::kInvalidArgument, "'" + url + "': " + why + "; write ws://HOST:PORT or wss://HOST:PORT"};
  };
  const auto scheme = std::find_if(std::begin(kSchemes), std::end(kSchemes),
                                   [&](const Scheme& s) { return url.starts_with(s.prefix); });
  if (scheme == std::end(kSchemes)) return refuse("not a WebSocket address");
  std::string authority = url.substr(scheme->prefix.size());
  WebSocketUrl result{.security = scheme->security, .host = {}, .port = scheme->port, .target = "/fly"};
  if (const size_t slash = authority.find('/'); slash != std::string::npos) {
    result.target = authority.substr(slash);
    const size_t path_end = std::min(result.target.find('?'), result.target.size());
    if (result.target[path_end - 1] == '/') result.target.insert(path_end, "fly");  // of the page there
    authority.resize(slash);
  }
  const size_t bracket = authority.find(']');
  const size_t colon = authority.find(':', bracket == std::string::npos ? 0 : bracket);
  result.host = authority.substr(0, colon);
  if (colon != std::string::npos) result.port = authority.substr(colon + 1);
  if (result.host.starts_with('[')) result.host = result.host.substr(1, result.host.size() - 2);
  if (result.host.empty()) return refuse("no host");
  if (result.port.empty() || result.port.size() > 5 ||
      result.port.find_first_not_of("0123456789") != std::string::npos || std::stoi(result.port) < 1 ||
      std::stoi(result.port) > 65'535)
    return refuse("port '" + result.port + "' is not 1 to 65535");
  for (const std::string& part : {result.host, result.target})
    if (part.find_first_of(std::string(" \t\r\n\0", 5)) != std::string::npos) return refuse("white space");
  return result;
}

std::string withArea(const std::string& target, uint32_t area) {
  constexpr std::string_view kName = "area=";
  const size_t query = std::min(target.find('?'), target.size());
  std::string result = target.substr(0, query) + "?";
  for (size_t from = query + 1; from < target.size();) {
    const size_t to = std::min(target.find('&', from), target.size());
    if (!std::string_view(target).substr(from).starts_with(kName)) result += target.substr(from, to - from) + "&";
    from = to + 1;
  }
  return result.append(kName) + std::to_string(area);
}

struct WebSocketClient::Impl {
  asio::io_context io{1};
  asio::ssl::context tls{asio::ssl::context::tls_client};
  std::optional<transport::WebSocket> stream;  // replaced by open()
  std::string name;                            // for messages
  beast::flat_buffer incoming;
  std::deque<Bytes> outgoing;  // the front one is being written
  const std::function<Status(ByteSpan)>* on_message = nullptr;
  size_t unsent_bytes = 0;
  std::optional<Error> failure;

  Status runStep(const std::stop_token& stop);
  Status open(const std::string& url, std::chrono::milliseconds timeout, const Options& options);
  Status connectTo(const WebSocketUrl& url, std::chrono::milliseconds timeout, const Options& options);
  Status startTls(const WebSocketUrl& url, const Options& options);
  Status shakeHands(const WebSocketUrl& url, std::chrono::milliseconds timeout, const Options& options);
  void read();
  void write();
  void fail(const error_code& error);
};

Status WebSocketClient::Impl::open(const std::string& url, std::chrono::milliseconds timeout, const Options& options) {
  const Result<WebSocketUrl> parsed = parseWebSocketUrl(url);
  if (!parsed.ok()) return parsed.error();
  name = url;
  const std::stop_callback on_stop(options.stop, [this] { io.stop(); });
  if (Status s = connectTo(*parsed, timeout, options); !s.ok()) return s;
  if (parsed->security == Security::kTls)
    if (Status s = startTls(*parsed, options); !s.ok()) return s;
  return shakeHands(*parsed, timeout, options);
}

// Runs what was begun to its end.
Status WebSocketClient::Impl::runStep(const std::stop_token& stop) {
  io.restart();  // before it is asked, so that a stop after that ends the run
  if (!stop.stop_requested()) io.run();
  if (stop.stop_requested()) return Error{ErrorCode::kIo, name + ": connecting was stopped"};
  return {};
}

Status WebSocketClient::Impl::connectTo(const WebSocketUrl& url, std::chrono::milliseconds timeout,
                                        const Options& options) {
  error_code error;
  tcp::resolver resolver(io);
  tcp::resolver::results_type endpoints;
  resolver.async_resolve(url.host, url.port,
                         [&](error_code e, const tcp::resolver::results_type& found) { error = e, endpoints = found; });
  if (Status s = runStep(options.stop); !s.ok()) return s;
  if (error) return Error{ErrorCode::kNotFound, name + ": no such host: " + error.message()};
  if (url.security == Security::kTls) {
    tls.set_verify_mode(asio::ssl::verify_peer);
    tls.set_verify_callback(asio::ssl::host_name_verification(url.host));
    if (options.ca_file.empty())
      tls.set_default_verify_paths(error);
    else
      tls.load_verify_file(options.ca_file, error);
    if (error) return Error{ErrorCode::kInvalidArgument, "--ca '" + options.ca_file + "': " + error.message()};
    stream.emplace(transport::Transport(beast::tcp_stream(io), tls));
  } else {
    stream.emplace(transport::Transport(beast::tcp_stream(io)));
  }
  beast::tcp_stream& socket = stream->transport().next_layer();
  socket.expires_after(timeout);
  socket.async_connect(endpoints, [&](error_code e, const tcp::endpoint&) { error = e; });
  if (Status s = runStep(options.stop); !s.ok()) return s;
  if (error)
    return Error{ErrorCode::kIo,
                 name + ": cannot connect: " + error.message() + "; is `foreland serve` running there?"};
  socket.socket().set_option(tcp::no_delay(true), error);  // poses are small and urgent
  return {};
}

Status WebSocketClient::Impl::startTls(const WebSocketUrl& url, const Options& options) {
  error_code error;
  stream->transport().handshakeAsClient(url.host, [&](error_code e) { error = e; });
  if (Status s = runStep(options.stop); !s.ok()) return s;
  if (!error) return {};
  return Error{ErrorCode::kIo, name + ": no TLS: " + error.message() +
                                   (options.ca_file.empty() ? "; " + options.ca_advice + " of its certificate" : "")};
}

Status WebSocketClient::Impl::shakeHands(const WebSocketUrl& url, std::chrono::milliseconds timeout,
                                         const Options& options) {
  stream->transport().next_layer().expires_never();
  stream->setLimits({.handshake_timeout = timeout, .max_message_bytes = proto::kMaxServerMessageBytes, .pings = true});
  const std::string authorization = options.token.empty() ? "" : "Bearer " + options.token;
  error_code error;
  transport::WebSocket::Answer answer;
  const std::string target = options.area ? withArea(url.target, *options.area) : url.target;
  stream->shakeHands(url.host + ":" + url.port, target, authorization, answer, [&](error_code e) {
    error = e;
    io.stop();  // Beast's timer goes on where the server declines
  });
  if (Status s = runStep(options.stop); !s.ok()) return s;
  if (!error) return {};
  const bool is_answer = answer.status != 0 && answer.status != 101;
  const std::string said = printable(answer.text.substr(0, answer.text.find_last_not_of(" \r\n") + 1), kMaxSaidBytes);
  return Error{ErrorCode::kIo, name + ": is not a Foreland server, or refuses viewers: " + error.message() +
                                   (is_answer ? " (HTTP " + std::to_string(answer.status) + ")" : "") +
                                   (said.empty() ? "" : "; it says: " + said) +
                                   (answer.status == 401 ? "; " + options.token_advice : "")};
}

void WebSocketClient::Impl::fail(const error_code& error) {
  if (failure) return;
  std::string why = error == beast::websocket::error::closed || error == asio::error::eof
                        ? "the server closed the connection"
                        : error.message();
  if (const auto& reason = stream->reason(); error == beast::websocket::error::closed && !reason.reason.empty())
    why += ": " + std::string(reason.reason.data(), reason.reason.size());
  failure = Error{ErrorCode::kIo, name + ": connection lost: " + why};
  io.stop();
}

void WebSocketClient::Impl::read() {
  stream->read(incoming, [this](error_code error, size_t) {
    if (error) return fail(error);
    const auto bytes = incoming.cdata();
    const Status taken = (*on_message)({static_cast<const uint8_t*>(bytes.data()), bytes.size()});
    incoming.consume(incoming.size());
    if (!taken.ok()) {
      failure = taken.error();
      io.stop();
      return;
    }
    read();
  });
}

void WebSocketClient::Impl::write() {
  stream->write(asio::buffer(outgoing.front()), [this](error_code error, size_t) {
    if (error) return;  // reading reports the loss, after what still came in
    unsent_bytes -= outgoing.front().size();
    outgoing.pop_front();
    if (!outgoing.empty()) write();
  });
}

WebSocketClient::WebSocketClient(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
WebSocketClient::~WebSocketClient() = default;
WebSocketClient::WebSocketClient(WebSocketClient&&) noexcept = default;
WebSocketClient& WebSocketClient::operator=(WebSocketClient&&) noexcept = default;

Result<WebSocketClient> WebSocketClient::connect(const std::string& url, std::chrono::milliseconds timeout,
                                                 const Options& options) try {
  auto impl = std::make_unique<Impl>();
  if (Status s = impl->open(url, timeout, options); !s.ok()) return s.error();
  return WebSocketClient(std::move(impl));
} catch (const std::exception& e) { return Error{ErrorCode::kIo, url + ": " + e.what()}; }

Result<WebSocketClient> WebSocketClient::connect(const std::string& url, std::chrono::milliseconds timeout) {
  return connect(url, timeout, Options());
}

void WebSocketClient::send(Bytes message) {
  impl_->unsent_bytes += message.size();
  impl_->outgoing.push_back(std::move(message));
  if (impl_->outgoing.size() == 1) impl_->write();
}

Status WebSocketClient::run(Clock::time_point until, const std::function<Status(ByteSpan)>& on_message) try {
  const bool is_first = impl_->on_message == nullptr;
  impl_->on_message = &on_message;
  if (is_first) impl_->read();
  if (!impl_->failure) {
    impl_->io.restart();
    impl_->io.run_until(until);
  }
  if (impl_->failure) return *impl_->failure;
  return {};
} catch (const std::exception& e) { return Error{ErrorCode::kIo, impl_->name + ": " + e.what()}; }

void WebSocketClient::wake() {
  asio::post(impl_->io, [io = &impl_->io] { io->stop(); });
}

size_t WebSocketClient::unsentBytes() const { return impl_->unsent_bytes; }

LostBy WebSocketClient::lostBy() const {
  return impl_->stream->reason().code == beast::websocket::close_code::service_restart ? LostBy::kMigrate
                                                                                       : LostBy::kFailure;
}

void WebSocketClient::close(std::chrono::milliseconds longest) try {
  if (impl_->failure) return;
  const std::function<Status(ByteSpan)> ignore = [](ByteSpan) { return Status(); };
  impl_->on_message = &ignore;
  impl_->stream->close(beast::websocket::close_code::normal, [this](error_code) { impl_->io.stop(); });
  impl_->io.restart();
  impl_->io.run_for(longest);
  impl_->failure = Error{ErrorCode::kIo, impl_->name + ": closed"};
} catch (const std::exception&) {
  return;  // the connection is being given up anyway
}

}  // namespace foreland::client
