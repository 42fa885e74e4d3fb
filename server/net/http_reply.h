// What the server answers to a plain HTTP request, as values: no socket, no library types. Pure; any thread.
#pragma once

#include <functional>
#include <memory>
#include <string>
#include <string_view>

#include "server/net/static_files.h"

namespace foreland::server {

struct HttpRequest {
  std::string_view method;         // "GET"
  std::string_view target;         // path and query as they came
  std::string_view if_none_match;  // empty if absent
};

struct HttpReply {
  unsigned status = 200;
  std::string content_type = "text/plain; charset=utf-8";
  std::string cache_control = "no-store";
  std::string etag{};                         // empty: none
  std::shared_ptr<const std::string> body{};  // never null
};

// What plain requests can reach.
struct HttpSite {
  StaticFiles files;
  std::function<std::string()> metrics;  // text of /metrics
};

// /healthz, /metrics, /fly (which asks for WebSocket), else a file. HEAD is answered as GET; whoever sends leaves the
// body out.
HttpReply replyTo(const HttpRequest& request, const HttpSite& site);

// A short plain text, for what goes wrong.
HttpReply textReply(unsigned status, std::string text);

}  // namespace foreland::server
