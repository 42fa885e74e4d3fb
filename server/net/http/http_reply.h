// What the server answers to a plain HTTP request, as values without a socket or a library's types. Pure; any thread.
#pragma once

#include <functional>
#include <memory>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "server/net/http/static_files.h"

namespace foreland::server {

struct HttpRequest {
  std::string_view method;  // "GET"
  std::string_view target;  // path and query, percent-encoded
  // The fields of these names; empty if absent.
  std::string_view if_none_match;
  std::string_view accept_encoding{};
  std::string_view range{};
  std::string_view if_range{};
  // It has the key of a WebSocket's handshake and does not ask for the upgrade: a proxy has not passed that on.
  bool lost_its_upgrade = false;
};

// Of which origins browsers let pages read a reply.
enum class ReadableBy {
  kOwnPage,
  kAllowedOrigins,  // those that may connect (--allow-origin)
  kAnyOrigin
};

struct HttpReply {
  unsigned status = 200;
  std::string content_type = "text/plain; charset=utf-8";
  std::string cache_control = "no-store";
  std::string etag{};                         // empty for replies that have none
  std::shared_ptr<const std::string> body{};  // never null
  std::string encoding{};                     // of the body: br, gzip, or empty
  bool varies = false;                        // whether another client may get another encoding
  std::string content_range{};                // of a part of a file
  std::string location{};                     // where the client is sent on to
  size_t part_begin = 0, part_size = std::string::npos;
  ReadableBy readable_by = ReadableBy::kOwnPage;

  // What is sent of the body.
  std::string_view content() const { return std::string_view(*body).substr(part_begin, part_size); }
};

// Fields of every reply.
inline constexpr std::pair<const char*, const char*> kRules[] = {{"X-Content-Type-Options", "nosniff"},
                                                                 {"Referrer-Policy", "no-referrer"}};
// Fields of what browsers run: the page, and the scripts of its workers, which browsers hold to the rules that came
// with them. The page runs its own scripts and its module only, and connects to any server of terrain (?server=);
// nobody else's page may frame it or share its process.
inline constexpr std::pair<const char*, const char*> kPageRules[] = {
    {"Content-Security-Policy",
     "default-src 'self'; script-src 'self' 'wasm-unsafe-eval'; style-src 'self' 'unsafe-inline'; img-src 'self' data: "
     "blob:; connect-src 'self' ws: wss: http: https:; object-src 'none'; base-uri 'none'; frame-ancestors 'self'"},
    {"Cross-Origin-Opener-Policy", "same-origin"},
    {"Cross-Origin-Embedder-Policy", "require-corp"}};

// Whether browsers run what has such a content type, and not only show or read it.
bool isRunByBrowsers(std::string_view content_type);

// All that plain requests can reach.
struct HttpSite {
  StaticFiles files;
  std::function<std::string()> metrics;  // returns the text of /metrics; null: there is no such page
  // Why no further viewer should be sent here, for /readyz; empty if one may. Null: always ready.
  std::function<std::string()> unready{};
  // The names of its scenes, if it has several (scene_paths.h). Below /NAME/ are then the files of that scene, and else
  // those of the page; /scenes.html is what / shows.
  std::vector<std::string> scenes{};
};

// Answers /livez (the server runs), /readyz and /healthz (503 with the reason if no further viewer should come), and
// /metrics; /fly (with the advice to use WebSocket), and files by their paths. HEAD is answered as GET; the sender
// leaves the body out.
HttpReply replyTo(const HttpRequest& request, const HttpSite& site);

// Whether `target` is an address of viewers, which a page may also ask by plain HTTP, why its WebSocket does not open.
bool isForViewers(std::string_view target, const HttpSite& site);
// Why a WebSocket at an address that is no scene's does not open, with those that are.
std::string noSuchScene(const HttpSite& site);

// Whether a request for `target` is for one of those four: answered also when the server is full.
bool isForOperators(std::string_view target);

// A reply of one line of plain text, for errors.
HttpReply textReply(unsigned status, std::string text);

}  // namespace foreland::server
