#include "apps/serve/serve_options.h"

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdio>
#include <memory>
#include <thread>
#include <utility>

#include "apps/options.h"
#include "apps/serve/toml_config.h"
#include "base/time.h"
#include "proto/message/keyframe_interval.h"
#include "server/net/listen_address.h"
#include "server/net/token.h"

namespace foreland::apps {
namespace {

void addScene(CLI::App& app, ServeFlags& flags) {
  app.add_option("SCENE", flags.scene, "scene file made by `foreland build`")->required();
  app.add_option("--threads", flags.threads, "threads that compute")->check(CLI::Range(1, 1024))->capture_default_str();
  app.add_option("--occlusion", flags.occlusion,
                 "on: what ridges hide is not sent to viewers that ask for that (foreland fly --occlusion on)")
      ->check(CLI::IsMember({"on", "off"}))
      ->capture_default_str();
  app.add_option(
         "--viewer-memory-mib", flags.viewer_memory_mib,
         "MiB of terrain that a viewer may remember at most; the server needs up to a tenth of that for each viewer")
      ->check(CLI::Range(0.0, 1024.0) & isFinite())
      ->capture_default_str();
  app.add_option("--max-section-nodes", flags.max_section_nodes,
                 "nodes that a viewer's section may have; its tolerance rises until it has no more")
      ->check(CLI::Range(1'000, 100'000'000))
      ->capture_default_str();
  app.add_option("--tau", flags.tau_px, "tolerance in pixels, for viewers that name none")
      ->check(CLI::Range(0.01, 1000.0) & isFinite())
      ->capture_default_str();
  app.add_option("--keyframe-ms", flags.keyframe_ms,
                 "time between keyframes, for viewers that name none: 20 to 10000, or adaptive, or 100-500")
      ->capture_default_str();
  app.add_option("--web", flags.web,
                 "directory of the page; by default the one that was built or installed with this program");
}

void addPort(CLI::App& app, ServeFlags& flags) {
  app.add_option("--listen", flags.listen, "address and port; port 0 picks a free one")->capture_default_str();
  app.add_option("--metrics-listen", flags.metrics_listen,
                 "address and port of its own for /metrics, which --listen then does not answer, /livez and /readyz");
  app.add_option("--tls-cert", flags.tls_cert, "certificate chain in PEM format; SIGHUP reads it again");
  app.add_option("--tls-key", flags.tls_key, "its private key");
  app.add_option("--allow-origin", flags.allow_origin,
                 "pages of this origin may connect, beside the server's own; may be repeated (default: any)");
  app.add_option("--token-secret", flags.token_secret,
                 "file of the secret with which `foreland token` signs; viewers need a token then");
  app.add_option("--trusted-proxy", flags.trusted_proxy,
                 "address or network of a proxy whose X-Forwarded-For is believed; may be repeated");
  app.add_option("--max-connections", flags.max_connections, "one more is told to try again later (503)")
      ->check(CLI::Range(1, 1'000'000))
      ->capture_default_str();
  app.add_option("--max-per-address", flags.max_per_address,
                 "likewise, of connections from one address (default 0: no limit, as behind a proxy)")
      ->check(CLI::Range(0, 1'000'000))
      ->capture_default_str();
  app.add_option("--queue-mib", flags.queue_mib,
                 "MiB held for a viewer at most: sent by it and not yet read, kept, or not yet sent to it; while it is "
                 "more, its requests wait, and its longer messages are refused")
      ->check(CLI::Range(1.0, 4096.0) & isFinite())
      ->capture_default_str();
  app.add_option("--idle-seconds", flags.idle_seconds,
                 "a viewer that sends nothing, or reads nothing of what waits for it, for so long is disconnected")
      ->check(CLI::Range(1.0, 3600.0) & isFinite())
      ->capture_default_str();
}

void addOperation(CLI::App& app, ServeFlags& flags) {
  app.add_option("--drain-seconds", flags.drain_seconds,
                 "SIGTERM hands viewers over to other servers for so long at most; Ctrl-C does not")
      ->check(CLI::Range(0.0, 3600.0) & isFinite())
      ->capture_default_str();
  app.add_option("--log-level", flags.log_level, "what to log on standard error")
      ->check(CLI::IsMember({"debug", "info", "warning", "error", "off"}))
      ->capture_default_str();
  app.add_option("--log", flags.log_format, "text, or json: an object on each line")
      ->check(CLI::IsMember({"text", "json"}))
      ->capture_default_str();
  app.set_config("--config", "", "read options from this TOML file; those of the command line win");
  app.allow_config_extras(false);
  app.config_formatter(std::make_shared<TomlConfig>());
}

}  // namespace

ParsedServeFlags parseServeFlags(int argc, const char* const* argv) {
  ServeFlags flags;
  flags.threads = std::max(1u, std::thread::hardware_concurrency());
  CLI::App app("Serve a scene to viewers, and the page that shows it.", "foreland serve");
  addScene(app, flags);
  addPort(app, flags);
  addOperation(app, flags);
  bool prints_config = false;
  app.add_flag("--print-config", prints_config, "print all options as a file for --config, and end")
      ->configurable(false);
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) { return {std::move(flags), app.exit(error) == 0 ? 0 : 2}; }
  if (!prints_config) return {std::move(flags), std::nullopt};
  std::fputs(app.config_to_str(true, true).c_str(), stdout);
  return {std::move(flags), 0};
}

Result<server::ServeOptions> serveOptions(const ServeFlags& flags) {
  server::ServeOptions options;
  auto listen = server::parseListenAddress(flags.listen);
  if (!listen) return listen.error();
  options.listen = *listen;
  if (!flags.metrics_listen.empty()) {
    auto metrics_listen = server::parseListenAddress(flags.metrics_listen, "--metrics-listen");
    if (!metrics_listen) return metrics_listen.error();
    options.metrics_listen = *metrics_listen;
  }
  if (!flags.token_secret.empty()) {
    auto secret = server::readTokenSecret(flags.token_secret);
    if (!secret) return secret.error();
    options.gate.token_secret = std::move(*secret);
  }
  options.gate.allowed_origins = flags.allow_origin;
  options.gate.trusted_proxies = flags.trusted_proxy;
  options.tls_certificate = flags.tls_cert;
  options.tls_key = flags.tls_key;
  options.threads = flags.threads;
  options.max_connections = flags.max_connections;
  if (flags.max_per_address > 0) options.max_connections_per_address = flags.max_per_address;
  options.limits.viewer_bytes = static_cast<size_t>(flags.queue_mib * 1048576);
  options.limits.queue_bytes = std::max(options.limits.queue_bytes, options.limits.viewer_bytes);
  options.idle_timeout = Duration::seconds(flags.idle_seconds);
  options.session.max_section_nodes = flags.max_section_nodes;
  options.session.tau_px = flags.tau_px;
  const auto interval = proto::keyframeIntervalFrom(flags.keyframe_ms);
  if (!interval) return Error{interval.error().code, "--keyframe-ms: " + interval.error().message};
  options.session.keyframe_interval = interval->shortest;
  options.session.longest_interval = interval->longest;
  options.session.most_early = Duration::milliseconds(100);  // at most half an interval (decision 0024)
  options.session.max_memory_bytes = static_cast<uint32_t>(flags.viewer_memory_mib * 1048576);
  options.version = FORELAND_VERSION;
  return options;
}

}  // namespace foreland::apps
