#include "server/net/http/http_reply.h"

#include <algorithm>
#include <iterator>
#include <optional>
#include <utility>

#include "server/net/http/http_fields.h"
#include "server/net/http/scene_paths.h"

namespace foreland::server {
namespace {

constexpr std::string_view kViewerPath = "/fly";
constexpr const char* kLostUpgrade =
    "This is the handshake of a WebSocket without its Upgrade: a proxy on the way does not pass that on. nginx needs "
    "proxy_http_version 1.1, proxy_set_header Upgrade $http_upgrade and proxy_set_header Connection \"upgrade\"; "
    "see docs/PUBLIC_PORT.md.";

std::optional<int> hexDigit(char c) {
  if (c >= '0' && c <= '9') return c - '0';
  if (c >= 'a' && c <= 'f') return c - 'a' + 10;
  if (c >= 'A' && c <= 'F') return c - 'A' + 10;
  return std::nullopt;
}

// The path of a request's target with percent-encoding undone; nothing if it is malformed or contains a zero byte.
std::optional<std::string> pathOf(std::string_view target) {
  target = target.substr(0, target.find_first_of("?#"));
  std::string path;
  for (size_t i = 0; i < target.size(); ++i) {
    char c = target[i];
    if (c == '%') {
      if (i + 2 >= target.size()) return std::nullopt;
      const auto high = hexDigit(target[i + 1]), low = hexDigit(target[i + 2]);
      if (!high || !low) return std::nullopt;
      c = static_cast<char>(*high * 16 + *low);
      i += 2;
    }
    if (c == '\0') return std::nullopt;
    path.push_back(c);
  }
  return path;
}

// The file in the form that is wanted. Parts are taken of the file as it is.
HttpReply formOf(const StaticFile& file, const HttpRequest& request) {
  HttpReply reply{.content_type = file.content_type,
                  .cache_control = file.cache_control,
                  .etag = file.etag,
                  .body = file.body,
                  .varies = file.brotli || file.gzip,
                  .readable_by = ReadableBy::kAllowedOrigins};
  if (!request.range.empty()) return reply;
  for (const auto& [coding, body] : {std::pair{"br", file.brotli}, {"gzip", file.gzip}}) {
    if (!body || !acceptsCoding(request.accept_encoding, coding)) continue;
    reply.body = body;
    reply.encoding = coding;
    reply.etag.insert(reply.etag.size() - 1, std::string("-") + coding);
    break;
  }
  return reply;
}

void takePart(HttpReply& reply, std::string_view range) {
  const size_t size = reply.body->size();
  const RequestedRange part = rangeOf(range, size);
  if (part.kind == RangeKind::kNone) return;
  if (part.kind == RangeKind::kUnsatisfiable) {
    reply = textReply(416, "The file has " + std::to_string(size) + " bytes.");
    reply.content_range = "bytes */" + std::to_string(size);
    return;
  }
  const auto [begin, end] = part.range;
  reply.status = 206;
  reply.part_begin = begin;
  reply.part_size = end - begin;
  reply.content_range = "bytes " + std::to_string(begin) + "-" + std::to_string(end - 1) + "/" + std::to_string(size);
}

HttpReply fileReply(const StaticFile& file, const HttpRequest& request) {
  HttpReply reply = formOf(file, request);
  if (namesTag(request.if_none_match, reply.etag)) {
    reply.status = 304;
    reply.body = std::make_shared<const std::string>();
  } else if (request.if_range.empty() || request.if_range == reply.etag) {
    takePart(reply, request.range);
  }
  return reply;
}

// What lies beside a scene is found from its own address on alone. Relative, for a proxy may have taken a path off.
HttpReply sentInto(const std::string& scene, const HttpRequest& request) {
  HttpReply reply = textReply(308, "This scene is at " + scene + "/");
  reply.location =
      scene + "/" + std::string(request.target.substr(std::min(request.target.find('?'), request.target.size())));
  return reply;
}

// Of a server with several scenes, what is a scene's own comes before what they share. A scene is not found below
// another.
const StaticFile* fileAt(const std::string& path, const std::optional<ScenePath>& in_scene, const HttpSite& site) {
  if (site.scenes.empty()) return site.files.find(path);
  if (!in_scene)
    return path == "/"                    ? site.files.find("/scenes.html")
           : path.starts_with("/scenes.") ? site.files.find(path)
                                          : nullptr;
  if (const StaticFile* own = site.files.find(path)) return own;
  return scenePathOf(in_scene->rest, site.scenes) ? nullptr : site.files.find(in_scene->rest);
}

}  // namespace

HttpReply textReply(unsigned status, std::string text) {
  return {.status = status, .body = std::make_shared<const std::string>(std::move(text) + "\n")};
}

bool isRunByBrowsers(std::string_view content_type) {
  return content_type.starts_with("text/html") || content_type.starts_with("text/javascript");
}

bool isForViewers(std::string_view target, const HttpSite& site) {
  const auto path = scenePathOf(target.substr(0, target.find('?')), site.scenes);
  return path && path->rest == kViewerPath;
}

std::string noSuchScene(const HttpSite& site) {
  std::string all;
  for (const std::string& name : site.scenes) all += (all.empty() ? "/" : ", /") + name + "/";
  return "There is no such scene here. This server has several, each with a path of its own: " + all;
}

bool isForOperators(std::string_view target) {
  constexpr std::string_view kPaths[] = {"/livez", "/readyz", "/healthz", "/metrics"};
  return std::find(std::begin(kPaths), std::end(kPaths), target.substr(0, target.find('?'))) != std::end(kPaths);
}

HttpReply replyTo(const HttpRequest& request, const HttpSite& site) {
  if (request.method != "GET" && request.method != "HEAD")
    return textReply(405, "Only GET and HEAD are understood here; viewers connect by WebSocket.");
  const auto path = pathOf(request.target);
  if (!path) return textReply(400, "The address is malformed.");
  if (*path == "/livez") return textReply(200, "ok");
  if (*path == "/healthz" || *path == "/readyz") {
    const std::string why = site.unready ? site.unready() : std::string();
    return why.empty() ? textReply(200, "ok") : textReply(503, why);
  }
  if (*path == "/metrics" && site.metrics) {
    HttpReply reply = textReply(200, site.metrics());
    reply.content_type = "text/plain; version=0.0.4; charset=utf-8";
    return reply;
  }
  if (request.lost_its_upgrade) return textReply(426, kLostUpgrade);
  const auto in_scene = scenePathOf(*path, site.scenes);
  if (in_scene && !site.scenes.empty() && in_scene->rest.empty())
    return sentInto(site.scenes[in_scene->scene], request);
  if (in_scene && in_scene->rest == kViewerPath)
    return textReply(426, "This address speaks WebSocket. Open / in a browser, or use: foreland fly ws://HOST:PORT");
  if (const StaticFile* file = fileAt(*path, in_scene, site)) return fileReply(*file, request);
  if (!in_scene) return textReply(404, noSuchScene(site));
  if (*path == "/")
    return textReply(404,
                     "The server runs, but it was started without the page (--web). "
                     "Viewers can connect by WebSocket: foreland fly ws://HOST:PORT");
  return textReply(
      404,
      "There is no such file here. The page is at /; a proxy that shows it under another path must take that path "
      "off.");
}

}  // namespace foreland::server
