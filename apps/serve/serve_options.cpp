#include "apps/serve/serve_options.h"

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdio>
#include <thread>
#include <utility>

#include "apps/options/command_line.h"
#include "apps/options/keyframe_option.h"
#include "apps/options/options.h"
#include "apps/options/toml_config.h"
#include "base/time.h"
#include "server/net/access/listen_address.h"
#include "server/net/access/token.h"

namespace foreland::apps {
namespace {

void addScene(CLI::App& app, ServeFlags& flags) {
  app.add_option(
         "SCENE", flags.scenes,
         "scene file made by `foreland build`, or its address in a store that answers ranges (https://HOST/SCENE.fls, "
         "s3://BUCKET/SCENE.fls); several are each at a path of its own, /NAME/ for NAME.fls, and / lists them")
      ->type_name(file("SCENE.fls"))
      ->required();
  app.add_option("--listen", flags.listen, "address and port; port 0 picks a free one")
      ->type_name(text("ADDRESS:PORT"))
      ->capture_default_str();
  app.add_option("--web", flags.web,
                 "directory of the page; by default the one that was built or installed with this program")
      ->type_name(folder("DIR"));
  app.add_option("--overlay", flags.overlay,
                 "GeoJSON, KML, KMZ, GPX, IGC or CSV of names that every page lays on the ground")
      ->type_name(file("FILE"))
      ->allow_extra_args(false);
  app.add_option("--threads", flags.threads, "threads that compute; 0 for one per processor")
      ->type_name(whole("N"))
      ->check(within(0, 1024))
      ->capture_default_str();
}

void addViews(CLI::App& app, ServeFlags& flags) {
  const auto add = [&](const char* name, auto& value, const char* what) {
    return app.add_option(name, value, what)->group("What viewers are sent");
  };
  add("--tau", flags.tau_px, "largest error on the screen in pixels, for viewers that name none")
      ->type_name(number("PX"))
      ->check(within(0.01, 1000.0))
      ->capture_default_str();
  add("--keyframe-ms", flags.keyframe_ms,
      "time between keyframes, for viewers that name none: 20 to 10000 milliseconds, or adaptive, or between two "
      "bounds, such as 100-500")
      ->type_name(numberOrText("MS"))
      ->check(keyframeInterval())
      ->capture_default_str();
  add("--occlusion", flags.occlusion,
      "what ridges hide is not sent to viewers that ask for that (the page, `foreland fly`); auto: as long as "
      "processors have room for it and it is worth what it takes, for each viewer; on: always")
      ->check(oneOf({"auto", "on", "off"}))
      ->capture_default_str();
}

void addLimits(CLI::App& app, ServeFlags& flags) {
  const auto add = [&](const char* name, auto& value, const char* what) {
    return app.add_option(name, value, what)->group("Limits")->capture_default_str();
  };
  add("--max-connections", flags.max_connections, "one more is told to try again later (503)")
      ->type_name(whole("N"))
      ->check(within(1, 1'000'000));
  add("--max-per-address", flags.max_per_address,
      "likewise, of connections from one address; 0: no limit, as behind a proxy")
      ->type_name(whole("N"))
      ->check(within(0, 1'000'000));
  add("--max-header-kib", flags.max_header_kib,
      "KiB that the fields of a request may have, such as cookies of a single sign-on; longer ones are refused (431)")
      ->type_name(whole("KIB"))
      ->check(within(1, 1024));
  add("--max-section-nodes", flags.max_section_nodes,
      "nodes that a viewer's section may have; its tolerance rises until it has no more")
      ->type_name(whole("N"))
      ->check(within(1'000, 100'000'000));
  add("--viewer-memory-mib", flags.viewer_memory_mib,
      "MiB of terrain that a viewer may remember at most, so that it is not sent again; the server needs about a "
      "fortieth of that for each viewer")
      ->type_name(number("MIB"))
      ->check(within(0.0, 1024.0));
  add("--queue-mib", flags.queue_mib,
      "MiB held for a viewer at most: sent by it and not yet read, kept, or not yet sent to it; while it is more, its "
      "requests wait, and its longer messages are refused")
      ->type_name(number("MIB"))
      ->check(within(1.0, 4096.0));
  add("--sight-memory-mib", flags.sight_memory_mib,
      "MiB that answering what is seen from where may take, once somebody asks: about 9 bytes for a sample; 0: such "
      "questions are not answered")
      ->type_name(number("MIB"))
      ->check(within(0.0, 1048576.0));
  add("--page-cache-mib", flags.page_cache_mib,
      "MiB of the ground that are held inflated for all viewers together, of a scene whose pages are coded (build "
      "--pages coded); at least 2 for each processor, and about 1000 unless vm.max_map_count is raised")
      ->type_name(number("MIB"))
      ->check(within(1.0, 1048576.0));
  add("--store-cache-mib", flags.store_cache_mib,
      "MiB on this machine's disk of each scene that is in a store; viewers who need more get a coarser tolerance")
      ->type_name(number("MIB"))
      ->check(within(1.0, 1048576.0));
  add("--store-cache-dir", flags.store_cache_dir, "folder for them; by default that of temporary files (TMPDIR)")
      ->type_name(folder("DIR"));
  add("--idle-seconds", flags.idle_seconds,
      "a viewer that sends nothing, or reads nothing of what waits for it, for so long is disconnected")
      ->type_name(number("S"))
      ->check(within(1.0, 3600.0));
}

void addGate(CLI::App& app, ServeFlags& flags) {
  const auto add = [&](const char* name, auto& value, const char* what) {
    return app.add_option(name, value, what)->group("Who may connect");
  };
  add("--tls-cert", flags.tls_cert, "certificate chain in PEM format; SIGHUP reads it again")->type_name(file("FILE"));
  add("--tls-key", flags.tls_key, "its private key")->type_name(file("FILE"));
  add("--allow-origin", flags.allow_origin, "pages of this origin may connect, beside the server's own; by default any")
      ->type_name(text("ORIGIN"));
  add("--token-secret", flags.token_secret,
      "file of the secret with which `foreland token` signs; viewers need a token then")
      ->type_name(file("FILE"));
  add("--trusted-proxy", flags.trusted_proxy,
      "address or network of a proxy whose X-Forwarded-For, or else Forwarded, is believed, and what its checks say of "
      "a fleet")
      ->type_name(text("ADDRESS"));
}

void addOperation(CLI::App& app, ServeFlags& flags) {
  const auto add = [&](const char* name, auto& value, const char* what) {
    return app.add_option(name, value, what)->group("Operation");
  };
  add("--metrics-listen", flags.metrics_listen,
      "address and port of its own for /metrics, which --listen then does not answer, /livez and /readyz")
      ->type_name(text("ADDRESS:PORT"));
  add("--agent-listen", flags.agent_listen,
      "address and port where HAProxy's agent-check is told what weight this server should have, by how busy it is")
      ->type_name(text("ADDRESS:PORT"));
  add("--drain-seconds", flags.drain_seconds,
      "SIGTERM hands viewers over to other servers for so long at most; Ctrl-C does not")
      ->type_name(number("S"))
      ->check(within(0.0, 3600.0))
      ->capture_default_str();
  add("--log-level", flags.log_level, "what to log on standard error")
      ->type_name(text("LEVEL"))
      ->check(oneOf({"debug", "info", "warning", "error", "off"}))
      ->capture_default_str();
  add("--log", flags.log_format, "json: an object on each line")->check(oneOf({"text", "json"}))->capture_default_str();
}

void addPrinting(CLI::App& app, bool& prints_config) {
  app.add_flag("--print-config", prints_config, "print all options as a file for --config, and end")
      ->configurable(false)
      ->group("Configuration");
}

const std::vector<Example> kExamples{
    {"a scene, at http://127.0.0.1:8080", "foreland serve hills.fls"},
    {"several scenes, which / lists", "foreland serve hills.fls alps.fls"},
    {"with TLS, for all addresses",
     "foreland serve hills.fls --listen 0.0.0.0:8443 --tls-cert cert.pem --tls-key key.pem"},
    {"a scene in a store, with checksums beside it (`foreland sums`)",
     "foreland serve https://example.com/earth.fls --store-cache-mib 200"},
    {"with paths and huts on its ground", "foreland serve hills.fls --overlay paths.gpx --overlay huts.geojson"},
    {"write a file of options, and use it", "foreland serve hills.fls --tau 2 --print-config > serve.toml"},
    {"", "foreland serve --config serve.toml"}};

}  // namespace

ParsedServeFlags parseServeFlags(int argc, const char* const* argv) {
  ServeFlags flags;
  CLI::App app("Serves a scene to viewers, and the page that shows it.", "foreland serve");
  addScene(app, flags);
  addViews(app, flags);
  addLimits(app, flags);
  addGate(app, flags);
  addOperation(app, flags);
  bool prints_config = false;
  addConfiguration(app);
  addPrinting(app, prints_config);
  const auto exit_code = parseCommandLine(app, argc, argv, kExamples);
  if (exit_code) return {std::move(flags), exit_code};
  if (!prints_config) return {std::move(flags), std::nullopt};
  std::fputs(configText(app).c_str(), stdout);
  return {std::move(flags), 0};
}

server::Occlusion occlusionOf(const ServeFlags& flags) {
  using server::Occlusion;
  return flags.occlusion == "off" ? Occlusion::kOff : flags.occlusion == "on" ? Occlusion::kOn : Occlusion::kAuto;
}

Result<server::ServeOptions> serveOptions(const ServeFlags& flags) {
  server::ServeOptions options;
  auto listen = server::parseListenAddress(flags.listen);
  if (!listen) return listen.error();
  options.listen = *listen;
  const auto further = [](const std::string& text, const char* flag,
                          std::optional<server::ListenAddress>& out) -> Status {
    if (text.empty()) return {};
    auto address = server::parseListenAddress(text, flag);
    if (!address) return address.error();
    out = *address;
    return {};
  };
  if (Status s = further(flags.metrics_listen, "--metrics-listen", options.metrics_listen); !s.ok()) return s.error();
  if (Status s = further(flags.agent_listen, "--agent-listen", options.agent_listen); !s.ok()) return s.error();
  if (!flags.token_secret.empty()) {
    auto secret = server::readTokenSecret(flags.token_secret);
    if (!secret) return secret.error();
    options.gate.token_secret = std::move(*secret);
  }
  options.gate.allowed_origins = flags.allow_origin;
  options.gate.trusted_proxies = flags.trusted_proxy;
  options.tls_certificate = flags.tls_cert;
  options.tls_key = flags.tls_key;
  options.threads = flags.threads > 0 ? flags.threads : std::max(1u, std::thread::hardware_concurrency());
  options.max_connections = flags.max_connections;
  options.max_header_bytes = flags.max_header_kib << 10;
  if (flags.max_per_address > 0) options.max_connections_per_address = flags.max_per_address;
  options.limits.viewer_bytes = static_cast<size_t>(flags.queue_mib * 1048576);
  options.limits.queue_bytes = std::max(options.limits.queue_bytes, options.limits.viewer_bytes);
  options.idle_timeout = Duration::seconds(flags.idle_seconds);
  options.session.occlusion = occlusionOf(flags);
  options.session.max_section_nodes = flags.max_section_nodes;
  options.session.tau_px = flags.tau_px;
  const auto interval = proto::keyframeIntervalFrom(flags.keyframe_ms);
  if (!interval) return Error{interval.error().code, "--keyframe-ms: " + interval.error().message};
  options.session.keyframe_interval = interval->shortest;
  options.session.longest_interval = interval->longest;
  options.session.max_early = Duration::milliseconds(100);  // at most half an interval (decision 0024)
  options.session.max_memory_bytes = static_cast<uint32_t>(flags.viewer_memory_mib * 1048576);
  options.version = FORELAND_VERSION;
  return options;
}

}  // namespace foreland::apps
