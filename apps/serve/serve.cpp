// `foreland serve SCENE...`: serves one scene, or several at paths of their own, to viewers over WebSocket, and the
// page that shows it over HTTP, until SIGTERM or SIGINT. Exit code 0 after a clean stop, 2 if scene, options or port
// cannot be used, 3 if the scene's file is lost meanwhile. The main thread waits for the signal; the server has threads
// of its own (docs/THREADS.md).
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
#include <vector>

#include "apps/serve/distant_scenes.h"
#include "apps/serve/gallery.h"
#include "apps/serve/overlay_files.h"
#include "apps/serve/serve_options.h"
#include "apps/serve/service.h"
#include "apps/stop_signal.h"
#include "base/result.h"
#include "server/net/access/listen_address.h"
#include "server/net/http/sea_file.h"
#include "server/net/memory_return.h"
#include "server/net/server.h"
#include "server/net/steady_clock.h"
#include "server/session/session.h"
#include "terrain/fetch/store_address.h"
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
std::map<std::string, std::string> imagesOf(const server::SceneObjects& objects, const std::string& folder) {
  std::map<std::string, std::string> files;
  for (size_t i = 0; i < objects.texels.size(); ++i) {
    const proto::ObjectModel& model = objects.set.models()[i];
    const auto faces = static_cast<uint32_t>(model.shape.faces.size());
    const proto::AtlasLayout atlas = proto::AtlasLayout::of(faces, model.atlas_side);
    if (objects.texels[i].empty()) continue;
    const uint32_t size[2] = {atlas.width(), atlas.height()};
    std::string body(reinterpret_cast<const char*>(size), sizeof(size));
    body.append(reinterpret_cast<const char*>(objects.texels[i].data()), objects.texels[i].size_bytes());
    files[fmt::format("{}/models/{}.rgba", folder, i)] = std::move(body);
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

Result<std::shared_ptr<const terrain::Scene>> openScene(const apps::ServeFlags& flags, const fs::path& name,
                                                        const server::Log& log) {
  if (!terrain::isInStore(name.string()))
    return terrain::openVerified(name, 0, static_cast<uint64_t>(flags.page_cache_mib * 1048576));
  return apps::openFromStore(name.string(),
                             {static_cast<uint64_t>(flags.store_cache_mib * 1048576), flags.store_cache_dir,
                              [log](const std::string& what) { log(server::Severity::kWarning, what); }});
}

// Those of `flags`, in its order, and what `options` lack for them: files, and that sessions prefetch.
Result<std::vector<server::ServedScene>> openScenes(const apps::ServeFlags& flags, server::ServeOptions& options) {
  const bool is_gallery = flags.scenes.size() > 1;
  std::vector<apps::GalleryScene> gallery;
  std::vector<server::ServedScene> served;
  size_t bytes = 0;
  bool is_distant = false;
  const auto names = is_gallery ? apps::galleryNames(flags.scenes) : std::vector<std::string>(1);
  if (!names) return names.error();
  for (size_t i = 0; i < flags.scenes.size(); ++i) {
    auto scene = openScene(flags, flags.scenes[i], options.log);
    if (!scene) return scene.error();
    gallery.push_back({(*names)[i], *scene});
    bytes += (*scene)->records().size_bytes();
    is_distant = is_distant || (*scene)->supply();
  }
  if (Status s = apps::checkDifferent(gallery); !s.ok()) return s.error();
  for (const apps::GalleryScene& scene : gallery) {
    auto world = openWorld(flags, scene.scene, options.log);
    if (!world) return world.error();
    const std::string folder = is_gallery ? "/" + scene.name : "";
    options.files.merge(imagesOf((*world)->hierarchy.objects(), folder));
    if (scene.scene->grid().isCube())
      options.files[folder + "/sea.bin"] = server::seaFile(scene.scene->hasSea(), scene.scene->vertical().undulations);
    served.push_back({scene.name, std::move(*world)});
  }
  if (is_gallery) options.files.merge(apps::galleryFiles(gallery));
  if (bytes > kLargeSceneBytes || is_distant) options.session.prefetch_ahead = Duration::milliseconds(2000);
  return served;
}

// What is served, for people.
std::string titleOf(const std::vector<server::ServedScene>& scenes) {
  if (scenes.size() == 1) return scenes.front().world->hierarchy.scene().origin().title;
  std::string names;
  for (const server::ServedScene& scene : scenes) names += (names.empty() ? "" : ", ") + scene.name;
  return fmt::format("{} scenes ({})", scenes.size(), names);
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
  auto scenes = openScenes(flags, *options);
  if (!scenes) return fail(scenes.error());
  options->files.merge(*overlays);
  if (options->web.empty())
    options->log(server::Severity::kWarning,
                 "the page is not built, so only `foreland fly` can connect; ./demo builds it");
  auto running = scenes->size() == 1 ? server::Server::listen(scenes->front().world, *options, server::steadyNow)
                                     : server::Server::listen(*scenes, *options, server::steadyNow);
  if (!running) return fail(running.error());
  announce(**running, *options, titleOf(*scenes));
  run(**running, options->log, flags.drain_seconds, stop_signals);
  return 0;
}
