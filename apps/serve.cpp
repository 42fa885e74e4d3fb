// `foreland serve SCENE`: serves one scene to viewers over WebSocket, and the page that shows it over HTTP, until
// SIGTERM or SIGINT. Exit code 0 after a clean stop, 2 if scene, options or port cannot be used, 3 if the scene's file
// is lost meanwhile. The main thread waits for the signal; the server has threads of its own (docs/THREADS.md).
#include <fmt/format.h>
#include <spdlog/sinks/stdout_color_sinks.h>
#include <spdlog/spdlog.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <system_error>
#include <thread>
#include <vector>

#include "apps/options.h"
#include "apps/stop_signal.h"
#include "base/result.h"
#include "server/net/listen_address.h"
#include "server/net/server.h"
#include "server/net/steady_clock.h"
#include "server/session/session.h"
#include "terrain/store/mapped_file.h"
#include "terrain/store/scene.h"
#include "terrain/store/verify.h"

namespace {

using namespace foreland;
namespace fs = std::filesystem;

constexpr int kUsageError = 2;

struct Flags {
  fs::path scene;
  std::string listen = "127.0.0.1:8080", metrics_listen;
  size_t threads = std::max(1u, std::thread::hardware_concurrency());
  double tau_px = 1;
  int64_t keyframe_ms = 200;
  std::string web;  // empty for where builds and installations put it
  std::string log_level = "info";
  std::string occlusion = "off";
  size_t max_connections = server::ServeOptions{}.max_connections;
  size_t max_per_address = 0;  // 0: no limit
  double viewer_memory_mib = 64;
  double drain_seconds = 10;
};

// The exit code if the program should end at once; nothing if it should serve.
std::optional<int> parseFlags(int argc, char** argv, Flags& flags) {
  CLI::App app("Serve a scene to viewers, and the page that shows it.", "foreland serve");
  app.add_option("SCENE", flags.scene, "scene file made by `foreland build`")->required();
  app.add_option("--listen", flags.listen, "address and port; port 0 picks a free one")->capture_default_str();
  app.add_option("--metrics-listen", flags.metrics_listen,
                 "address and port of its own for /metrics, which --listen then does not answer, /livez and /readyz");
  app.add_option("--threads", flags.threads, "threads that compute")->check(CLI::Range(1, 1024))->capture_default_str();
  app.add_option("--occlusion", flags.occlusion,
                 "on: what ridges hide is not sent to viewers that ask for that (foreland fly --occlusion on)")
      ->check(CLI::IsMember({"on", "off"}))
      ->capture_default_str();
  app.add_option(
         "--viewer-memory-mib", flags.viewer_memory_mib,
         "MiB of terrain that a viewer may remember at most; the server needs up to a tenth of that for each viewer")
      ->check(CLI::Range(0.0, 1024.0) & apps::isFinite())
      ->capture_default_str();
  app.add_option("--tau", flags.tau_px, "tolerance in pixels, for viewers that name none")
      ->check(CLI::Range(0.01, 1000.0) & apps::isFinite())
      ->capture_default_str();
  app.add_option("--keyframe-ms", flags.keyframe_ms, "time between keyframes, for viewers that name none")
      ->check(CLI::Range(20, 10'000))
      ->capture_default_str();
  app.add_option("--web", flags.web,
                 "directory of the page; by default the one that was built or installed with this program");
  app.add_option("--max-connections", flags.max_connections, "one more is told to try again later (503)")
      ->check(CLI::Range(1, 1'000'000))
      ->capture_default_str();
  app.add_option("--max-per-address", flags.max_per_address,
                 "likewise, of connections from one address (default: no limit, as behind a proxy)")
      ->check(CLI::Range(1, 1'000'000));
  app.add_option("--drain-seconds", flags.drain_seconds,
                 "SIGTERM hands viewers over to other servers for so long at most; Ctrl-C does not")
      ->check(CLI::Range(0.0, 3600.0) & apps::isFinite())
      ->capture_default_str();
  app.add_option("--log-level", flags.log_level, "what to log on standard error")
      ->check(CLI::IsMember({"debug", "info", "warning", "error", "off"}))
      ->capture_default_str();
  try {
    app.parse(argc, argv);
    return std::nullopt;
  } catch (const CLI::ParseError& error) { return app.exit(error) == 0 ? 0 : kUsageError; }
}

int fail(const Error& error) {
  std::fprintf(stderr, "foreland serve: %s\n", error.message.c_str());
  return kUsageError;
}

// build/release/bin/foreland-serve beside client/web/dist in the checkout, or bin/ beside share/ in an installation.
fs::path findPage(const std::string& flag) {
  if (!flag.empty()) return flag;
  std::error_code error;
  const fs::path bin = fs::read_symlink("/proc/self/exe", error).parent_path();
  for (const char* relative : {"../../../client/web/dist", "../share/foreland/web"})
    if (const fs::path candidate = (bin / relative).lexically_normal(); fs::exists(candidate / "index.html", error))
      return candidate;
  return {};
}

void startLog(const std::string& level) {
  auto logger = spdlog::stderr_color_mt("foreland");
  logger->set_pattern("%H:%M:%S %^%l%$ %v");
  logger->set_level(spdlog::level::from_str(level));
  spdlog::set_default_logger(std::move(logger));
}

void log(server::Severity severity, const std::string& line) {
  constexpr spdlog::level::level_enum kLevels[] = {spdlog::level::debug, spdlog::level::info, spdlog::level::warn};
  spdlog::log(kLevels[static_cast<size_t>(severity)], line);
}

// Larger scenes may not stay in memory, so sessions prefetch.
constexpr size_t kLargeSceneBytes = size_t{256} << 20;

server::ServeOptions makeOptions(const Flags& flags, const server::ListenAddress& listen, const terrain::Scene& scene) {
  server::ServeOptions options;
  options.listen = listen;
  options.version = FORELAND_VERSION;
  options.threads = flags.threads;
  options.max_connections = flags.max_connections;
  if (flags.max_per_address > 0) options.max_connections_per_address = flags.max_per_address;
  options.session.tau_px = flags.tau_px;
  options.session.keyframe_interval = Duration::milliseconds(flags.keyframe_ms);
  options.session.most_early = Duration::milliseconds(100);  // at most half an interval (decision 0024)
  options.session.max_memory_bytes = static_cast<uint32_t>(flags.viewer_memory_mib * 1048576);
  if (scene.nodes().size_bytes() > kLargeSceneBytes) options.session.prefetch_ahead = Duration::milliseconds(2000);
  options.web = findPage(flags.web);
  options.log = log;
  return options;
}

// The images of the models in the format that the page reads: width and height, then texels row by row.
std::map<std::string, std::string> imagesOf(const server::SceneObjects& objects) {
  std::map<std::string, std::string> files;
  for (size_t i = 0; i < objects.texels.size(); ++i) {
    const proto::ObjectModel& model = objects.set.models()[i];
    const auto faces = static_cast<uint32_t>(model.shape.faces.size());
    const proto::AtlasLayout atlas = proto::AtlasLayout::of(faces, model.atlas_side);
    if (objects.texels[i].empty()) continue;
    const uint32_t size[2] = {atlas.width(), atlas.height()};
    std::string body(reinterpret_cast<const char*>(size), sizeof(size));
    body.append(reinterpret_cast<const char*>(objects.texels[i].data()), objects.texels[i].size_bytes());
    files[fmt::format("/models/{}.rgba", i)] = std::move(body);
  }
  return files;
}

}  // namespace

int main(int argc, char** argv) {
  Flags flags;
  if (const auto exit_code = parseFlags(argc, argv, flags)) return *exit_code;
  const sigset_t stop_signals = apps::blockStopSignals();
  startLog(flags.log_level);

  auto listen = server::parseListenAddress(flags.listen);
  if (!listen) return fail(listen.error());
  std::optional<server::ListenAddress> metrics_listen;
  if (!flags.metrics_listen.empty()) {
    auto parsed = server::parseListenAddress(flags.metrics_listen, "--metrics-listen");
    if (!parsed) return fail(parsed.error());
    metrics_listen = *parsed;
  }
  terrain::endWhenAFileIsLost();
  auto scene = terrain::openVerified(flags.scene);
  if (!scene) return fail(scene.error());
  const std::string title = (*scene)->origin().title;
  auto objects = server::objectsOf(*scene);
  if (!objects) return fail(objects.error());
  const auto world = std::make_shared<server::World>(*scene, std::move(*objects));
  if (flags.occlusion == "on") {
    auto occlusion = server::SceneOcclusion::create(world->hierarchy);
    if (!occlusion) return fail(occlusion.error());
    world->occlusion = std::move(*occlusion);
    spdlog::info("occluders take {:.1f} MiB", static_cast<double>(world->occlusion->bytes()) / (1 << 20));
  }

  server::ServeOptions options = makeOptions(flags, *listen, **scene);
  options.metrics_listen = metrics_listen;
  options.files = imagesOf(world->hierarchy.objects());
  if (options.web.empty()) spdlog::warn("the page is not built, so only `foreland fly` can connect; ./demo builds it");
  auto running = server::Server::listen(world, options, server::steadyNow);
  if (!running) return fail(running.error());

  listen->port = (*running)->port();
  std::printf("serving %s at http://%s/\n", title.c_str(), toString(*listen).c_str());
  if (metrics_listen) {
    metrics_listen->port = (*running)->metricsPort();
    std::printf("metrics at http://%s/metrics\n", toString(*metrics_listen).c_str());
  }
  std::fflush(stdout);
  if (apps::waitForStop(stop_signals) == SIGTERM) (*running)->drain(Duration::seconds(flags.drain_seconds));
  (*running)->stop();
  return 0;
}
