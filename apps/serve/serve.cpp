// `foreland serve SCENE`: serves one scene to viewers over WebSocket, and the page that shows it over HTTP, until
// SIGTERM or SIGINT. Exit code 0 after a clean stop, 2 if scene, options or port cannot be used, 3 if the scene's file
// is lost meanwhile. The main thread waits for the signal; the server has threads of its own (docs/THREADS.md).
#include <fmt/format.h>
#include <spdlog/sinks/stdout_color_sinks.h>
#include <spdlog/spdlog.h>

#include <cstdio>
#include <filesystem>
#include <map>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <system_error>
#include <utility>

#include "apps/serve/overlay_files.h"
#include "apps/serve/serve_options.h"
#include "apps/serve/service.h"
#include "apps/stop_signal.h"
#include "base/result.h"
#include "server/net/access/listen_address.h"
#include "server/net/memory_return.h"
#include "server/net/server.h"
#include "server/net/steady_clock.h"
#include "server/session/session.h"
#include "terrain/store/file/mapped_file.h"
#include "terrain/store/scene.h"
#include "terrain/store/verify.h"

namespace {

using namespace foreland;
namespace fs = std::filesystem;

constexpr int kUsageError = 2;

int fail(const Error& error) {
  std::fprintf(stderr, "foreland serve: %s\n", error.message.c_str());
  return kUsageError;
}

// In an installation among its data, in a checkout where it was built.
fs::path findPage(const std::string& flag) {
  if (!flag.empty()) return flag;
  std::error_code error;
  const fs::path bin = fs::read_symlink("/proc/self/exe", error).parent_path();
  for (const char* relative : {FORELAND_DATA "/web", "../../../client/web/dist"})
    if (const fs::path candidate = (bin / relative).lexically_normal(); fs::exists(candidate / "index.html", error))
      return candidate;
  return {};
}

// Its messages are JSON texts in quotation marks already, where the format is JSON.
void startLog(const apps::ServeFlags& flags) {
  auto logger = spdlog::stderr_color_mt("foreland");
  logger->set_pattern(flags.log_format == "json" ? R"({"time":"%Y-%m-%dT%H:%M:%S.%e%z","level":"%l","message":%v})"
                                                 : "%H:%M:%S %^%l%$ %v");
  logger->set_level(spdlog::level::from_str(flags.log_level));
  spdlog::set_default_logger(std::move(logger));
}

server::Log logIn(const std::string& format) {
  return [is_json = format == "json"](server::Severity severity, const std::string& line) {
    constexpr spdlog::level::level_enum kLevels[] = {spdlog::level::debug, spdlog::level::info, spdlog::level::warn};
    using Json = nlohmann::json;
    spdlog::log(kLevels[static_cast<size_t>(severity)],
                is_json ? Json(line).dump(-1, ' ', false, Json::error_handler_t::replace) : line);
  };
}

// Larger scenes may not stay in memory, so sessions prefetch.
constexpr size_t kLargeSceneBytes = size_t{256} << 20;

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

Result<std::shared_ptr<const server::World>> openWorld(const apps::ServeFlags& flags,
                                                       std::shared_ptr<const terrain::Scene> scene,
                                                       const server::Log& log) {
  const server::SightSetup sight{server::SightSupply::Building::kOnAThread,
                                 {static_cast<uint64_t>(flags.sight_memory_mib * 1048576)}};
  auto world = server::openWorld(std::move(scene), apps::occlusionOf(flags), sight);
  if (world && (*world)->occlusion)
    log(server::Severity::kInfo,
        fmt::format("occluders take {:.1f} MiB", static_cast<double>((*world)->occlusion->bytes()) / (1 << 20)));
  return world;
}

// For as many connections as are to be taken, those of operators, and files.
void prepareDescriptors(const server::ServeOptions& options) {
  constexpr size_t kOthers = 200;
  const size_t wanted = options.max_connections + kOthers, allowed = apps::allowDescriptors(wanted);
  if (allowed < wanted)
    options.log(server::Severity::kWarning,
                fmt::format("the system lets this program open {} files and sockets, too few for --max-connections {}; "
                            "raise its limit (ulimit -n, or LimitNOFILE of systemd)",
                            allowed, options.max_connections));
}

// Tells people and systemd where the server is.
void announce(const server::Server& running, server::ServeOptions options, const std::string& title) {
  options.listen.port = running.port();
  std::printf("serving %s at http%s://%s/\n", title.c_str(), options.tls_certificate.empty() ? "" : "s",
              toString(options.listen).c_str());
  if (options.metrics_listen) {
    options.metrics_listen->port = running.metricsPort();
    std::printf("metrics at http://%s/metrics\n", toString(*options.metrics_listen).c_str());
  }
  if (options.agent_listen) {
    options.agent_listen->port = running.agentPort();
    std::printf("agent at %s\n", toString(*options.agent_listen).c_str());
  }
  std::fflush(stdout);
  apps::notifyService("READY=1");
}

// Until a signal to stop; SIGHUP reloads the certificate.
void run(server::Server& running, const server::Log& log, double drain_seconds, const sigset_t& signals) {
  int signal = apps::waitForSignal(signals);
  for (; signal == SIGHUP; signal = apps::waitForSignal(signals)) {
    const Status status = running.reloadTls();
    log(status.ok() ? server::Severity::kInfo : server::Severity::kWarning,
        status.ok() ? "read the certificate again" : "kept the certificate: " + status.error().message);
  }
  apps::endOnFurtherSignals(signals);
  apps::notifyService("STOPPING=1");
  if (signal == SIGTERM) running.drain(Duration::seconds(drain_seconds));
  running.stop();
}

}  // namespace

int main(int argc, char** argv) {
  const auto [flags, exit_code] = apps::parseServeFlags(argc, argv);
  if (exit_code) return *exit_code;
  server::MemoryReturn::prepare();
  const sigset_t stop_signals = apps::blockStopSignals();
  startLog(flags);
  auto options = apps::serveOptions(flags);
  if (!options) return fail(options.error());
  options->log = logIn(flags.log_format);
  options->web = findPage(flags.web);
  prepareDescriptors(*options);
  auto overlays = apps::overlayFiles(flags.overlay);
  if (!overlays) return fail(overlays.error());
  terrain::endWhenAFileIsLost();
  auto scene = terrain::openVerified(flags.scene, 0, static_cast<uint64_t>(flags.page_cache_mib * 1048576));
  if (!scene) return fail(scene.error());
  const std::string title = (*scene)->origin().title;
  if ((*scene)->records().size_bytes() > kLargeSceneBytes)
    options->session.prefetch_ahead = Duration::milliseconds(2000);
  auto world = openWorld(flags, *scene, options->log);
  if (!world) return fail(world.error());
  options->files = imagesOf((*world)->hierarchy.objects());
  options->files.merge(*overlays);
  if (options->web.empty())
    options->log(server::Severity::kWarning,
                 "the page is not built, so only `foreland fly` can connect; ./demo builds it");
  auto running = server::Server::listen(*world, *options, server::steadyNow);
  if (!running) return fail(running.error());
  announce(**running, *options, title);
  run(**running, options->log, flags.drain_seconds, stop_signals);
  return 0;
}
