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

#include "apps/options.h"
#include "apps/stop_signal.h"
#include "base/result.h"
#include "lab/proxy/proxy.h"
#include "server/net/steady_clock.h"

namespace foreland {

namespace {

struct LinkFlags {
  std::string listen = "127.0.0.1:8081", to = "127.0.0.1:8080", model = "fixed";
  std::filesystem::path trace_up, trace_down;
  std::optional<double> round_trip_ms, jitter_ms, up_mbit_s, down_mbit_s, queue_kib, loss_percent, stall_every_s,
      stall_ms;
  uint64_t seed = 1;
};

int fail(const Error& error) {
  std::fprintf(stderr, "foreland link: %s\n", error.message.c_str());
  return 2;
}

void addOptions(CLI::App& app, LinkFlags& f) {
  const auto number = [&](const char* name, std::optional<double>& value, double least, double most, const char* what) {
    app.add_option(name, value, what)->check(CLI::Range(least, most) & apps::isFinite());
  };
  app.add_option("--listen", f.listen, "address and port; port 0 picks a free one")->capture_default_str();
  app.add_option("--to", f.to, "the server's")->capture_default_str();
  app.add_option("--model", f.model, "fixed, wifi, lte, starlink or geo; the options below change it")
      ->capture_default_str();
  app.add_option("--trace-up", f.trace_up, "recorded rates in mahimahi's format, in place of the model's");
  app.add_option("--trace-down", f.trace_down, "likewise");
  number("--round-trip", f.round_trip_ms, 0, 60'000, "milliseconds, half of it each way");
  number("--jitter", f.jitter_ms, 0, 60'000, "milliseconds at most, half of it each way");
  number("--up", f.up_mbit_s, 0, 100'000, "Mbit/s; 0 for no limit");
  number("--down", f.down_mbit_s, 0, 100'000, "likewise");
  number("--queue", f.queue_kib, 0, 1 << 20, "KiB that the network takes off a sender ahead of the rate");
  number("--loss", f.loss_percent, 0, 100, "percent of the packets that are sent again, a round trip later");
  number("--stall-every", f.stall_every_s, 0.001, 86'400, "seconds from stall to stall");
  number("--stall", f.stall_ms, 0, 60'000, "milliseconds for which nothing moves; 0 for never");
  app.add_option("--seed", f.seed, "of the links' chance")->capture_default_str();
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
  CLI::App app("Let connections to a server be as slow as over a real network.", "foreland link");
  foreland::addOptions(app, flags);
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) { return app.exit(error) == 0 ? 0 : 2; }
  return foreland::run(flags);
}
