// `foreland link`: a proxy between viewers and a server that lets connections be as slow as over a real network, by the
// links of experiments, until SIGTERM or SIGINT. Exit code 0 after a clean stop, 2 if link or port cannot be used. The
// main thread waits for the signal; the proxy has a thread of its own.
#include <CLI/CLI.hpp>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <utility>

#include "apps/options/command_line.h"
#include "apps/options/options.h"
#include "apps/stop_signal.h"
#include "base/result.h"
#include "lab/proxy/proxy.h"
#include "lab/proxy/shared_line.h"
#include "server/net/steady_clock.h"

namespace foreland {

namespace {

struct LinkFlags {
  std::string listen = "127.0.0.1:8081", to = "127.0.0.1:8080", model = "fixed";
  std::filesystem::path trace_up, trace_down;
  std::optional<double> round_trip_ms, jitter_ms, up_mbit_s, down_mbit_s, queue_kib, loss_percent, stall_every_s,
      stall_ms;
  uint64_t seed = 1;
  bool is_shared = false;
};

int fail(const Error& error) {
  std::fprintf(stderr, "foreland link: %s\n", error.message.c_str());
  return 2;
}

void addOptions(CLI::App& app, LinkFlags& f) {
  const auto change = [&](const char* name, std::optional<double>& value, const char* unit, double least, double most,
                          const char* what) {
    app.add_option(name, value, what)
        ->type_name(apps::number(unit))
        ->check(apps::within(least, most))
        ->group("Changes of the model");
  };
  app.add_option("--listen", f.listen, "address and port; port 0 picks a free one")
      ->type_name(apps::text("ADDRESS:PORT"))
      ->capture_default_str();
  app.add_option("--to", f.to, "the server's")->type_name(apps::text("ADDRESS:PORT"))->capture_default_str();
  app.add_option("--model", f.model, "the link; the options below change it")
      ->type_name(apps::text("NAME"))
      ->check(apps::oneOf({"fixed", "wifi", "lte", "starlink", "geo"}))
      ->capture_default_str();
  app.add_option("--seed", f.seed, "of the links' chance")->type_name(apps::whole("S"))->capture_default_str();
  app.add_flag("--shared", f.is_shared, "all connections together have one link, instead of one each");
  change("--round-trip", f.round_trip_ms, "MS", 0, 60'000, "milliseconds, half of it each way");
  change("--jitter", f.jitter_ms, "MS", 0, 60'000, "milliseconds at most, half of it each way");
  change("--up", f.up_mbit_s, "MBIT", 0, 100'000, "Mbit/s; 0 for no limit");
  change("--down", f.down_mbit_s, "MBIT", 0, 100'000, "likewise");
  change("--queue", f.queue_kib, "KIB", 0, 1 << 20, "KiB that the network takes off a sender ahead of the rate");
  change("--loss", f.loss_percent, "PERCENT", 0, 100, "of the packets that are sent again, a round trip later");
  change("--stall-every", f.stall_every_s, "S", 0.001, 86'400, "seconds from stall to stall");
  change("--stall", f.stall_ms, "MS", 0, 60'000, "milliseconds for which nothing moves; 0 for never");
  app.add_option("--trace-up", f.trace_up, "recorded rates in mahimahi's format, in place of the model's")
      ->type_name(apps::file("FILE"))
      ->group("Changes of the model");
  app.add_option("--trace-down", f.trace_down, "likewise")
      ->type_name(apps::file("FILE"))
      ->group("Changes of the model");
}

Status readTrace(const std::filesystem::path& file, sim::LinkOptions& link) {
  if (file.empty()) return {};
  auto trace = sim::LinkTrace::read(file);
  if (!trace) return trace.error();
  link.trace = std::make_shared<const sim::LinkTrace>(std::move(*trace));
  return {};
}

Result<sim::LinkPair> linksOf(const LinkFlags& f) {
  auto model = sim::linkNamed(f.model);
  if (!model) return Error{model.error().code, "--model: " + model.error().message};
  model->round_trip_ms = f.round_trip_ms.value_or(model->round_trip_ms);
  model->jitter_ms = f.jitter_ms.value_or(model->jitter_ms);
  model->up_mbit_s = f.up_mbit_s.value_or(model->up_mbit_s);
  model->down_mbit_s = f.down_mbit_s.value_or(model->down_mbit_s);
  model->queue_kib = f.queue_kib.value_or(model->queue_kib);
  model->loss = f.loss_percent ? 0.01 * *f.loss_percent : model->loss;
  model->stall_every_s = f.stall_every_s.value_or(model->stall_every_s);
  model->stall_ms = f.stall_ms.value_or(model->stall_ms);
  if (model->stall_ms > 0 && 1e-3 * model->stall_ms >= model->stall_every_s)
    return Error{ErrorCode::kInvalidArgument, "--stall must be shorter than --stall-every, or nothing ever moves"};
  sim::LinkPair links = model->links();
  if (Status s = readTrace(f.trace_up, links.up); !s.ok()) return s.error();
  if (Status s = readTrace(f.trace_down, links.down); !s.ok()) return s.error();
  if (f.is_shared) return sim::LinkPair{lab::sharedByAll(links.up, f.seed), lab::sharedByAll(links.down, f.seed + 1)};
  return links;
}

int run(const LinkFlags& flags) {
  const sigset_t stop_signals = apps::blockStopSignals();
  const auto links = linksOf(flags);
  if (!links) return fail(links.error());
  auto listen = server::parseListenAddress(flags.listen);
  if (!listen) return fail(listen.error());
  const auto to = server::parseListenAddress(flags.to, "--to");
  if (!to) return fail(to.error());
  if (to->port == 0) return fail({ErrorCode::kInvalidArgument, "--to '" + flags.to + "': give the server's port"});
  const auto log = [](const std::string& line) { std::fprintf(stderr, "foreland link: %s\n", line.c_str()); };
  auto proxy = lab::Proxy::open({.doors = {{*listen, *links, flags.seed}}, .to = *to, .log = log}, server::steadyNow);
  if (!proxy) return fail(proxy.error());
  listen->port = (*proxy)->port(0);
  std::printf("link '%s' to %s at http://%s/\n", flags.model.c_str(), toString(*to).c_str(), toString(*listen).c_str());
  std::fflush(stdout);
  while (apps::waitForSignal(stop_signals) == SIGHUP) {}
  (*proxy)->stop();
  return 0;
}

}  // namespace

}  // namespace foreland

int main(int argc, char** argv) {
  foreland::LinkFlags flags;
  CLI::App app("Lets connections to a server be as slow as over a real network.", "foreland link");
  foreland::addOptions(app, flags);
  const auto exit_code = foreland::apps::parseCommandLine(
      app, argc, argv,
      {{"viewers at http://127.0.0.1:8081 as over a satellite",
        "foreland link --listen 127.0.0.1:8081 --to 127.0.0.1:8080 --model starlink"}});
  if (exit_code) return *exit_code;
  return foreland::run(flags);
}
