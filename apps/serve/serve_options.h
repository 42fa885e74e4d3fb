// The options of `foreland serve`, from the command line and from a TOML file: one table for both.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "base/result.h"
#include "server/net/server.h"
#include "terrain/store/coded/coded_pages.h"

namespace foreland::apps {

struct ServeFlags {
  std::vector<std::filesystem::path> scenes;
  std::string listen = "127.0.0.1:8080", metrics_listen, agent_listen;
  size_t threads = 0;  // 0: one per processor
  double tau_px = 1;
  std::string keyframe_ms = "200";
  std::vector<std::filesystem::path> overlay;
  std::string web;  // empty for where builds and installations put it
  std::string log_level = "info", log_format = "text";
  std::string occlusion = "auto";
  size_t max_connections = server::ServeOptions{}.max_connections;
  size_t max_per_address = 0;  // 0: no limit
  size_t max_header_kib = server::ServeOptions{}.max_header_bytes >> 10;
  double viewer_memory_mib = 64;
  size_t max_section_nodes = server::SessionOptions{}.max_section_nodes;
  double queue_mib = server::HostLimits{}.viewer_bytes / 1048576.0;
  double sight_memory_mib = 1024;
  double page_cache_mib = static_cast<double>(terrain::kDefaultPageCacheBytes >> 20);
  double store_cache_mib = 1024;
  std::string store_cache_dir;  // empty for that of temporary files
  double idle_seconds = server::ServeOptions{}.idle_timeout.toSeconds();
  double drain_seconds = 10;
  std::filesystem::path tls_cert, tls_key, token_secret;
  std::vector<std::string> allow_origin, trusted_proxy;
};

// The flags, or the exit code with which the program is to end at once: 0 after --help and --print-config, 2 after a
// mistake, about which a message was printed.
struct ParsedServeFlags {
  ServeFlags flags;
  std::optional<int> exit_code;
};
ParsedServeFlags parseServeFlags(int argc, const char* const* argv);

// Of --occlusion.
server::Occlusion occlusionOf(const ServeFlags& flags);

// What follows from the flags alone. An Error names the flag and the value that will not do.
Result<server::ServeOptions> serveOptions(const ServeFlags& flags);

}  // namespace foreland::apps
