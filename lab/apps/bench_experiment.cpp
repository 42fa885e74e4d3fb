#include "lab/apps/bench_experiment.h"
#include "apps/options/options.h"

#include <unistd.h>

#include <cstdio>
#include <cstring>

#include "apps/report/report.h"
#include "proto/message/control.h"

namespace foreland::apps {

void addThreadsOption(CLI::App& app, unsigned& threads) {
  app.add_option("--threads", threads, "that compute; the result does not depend on it; 0: one per processor")
      ->type_name(whole("N"))
      ->check(within(0, 256))
      ->capture_default_str()
      ->group("The experiment");
}

void addExperimentOptions(CLI::App& app, ExperimentArguments& args) {
  app.add_option("--out", args.out, "folder for the tables; without it a summary is printed and nothing is kept")
      ->type_name(folder("DIR"))
      ->group("The experiment");
  app.add_option("--calibration", args.calibration, "prices of a server's work, by `foreland bench calibrate`")
      ->type_name(file("FILE.json"))
      ->group("The experiment");
  app.add_option("--seed", args.seed, "of the links' chance")
      ->type_name(whole("S"))
      ->capture_default_str()
      ->group("The experiment");
  addThreadsOption(app, args.threads);
}

std::string commandText(int argc, char** argv) {
  std::string text = "foreland bench";
  for (int i = 1; i < argc; ++i) {
    const std::string word = argv[i];
    const bool has_value = word == "--out" || word == "--threads";
    if (has_value) ++i;
    if (has_value || word == "--json" || word.starts_with("--out=") || word.starts_with("--threads=")) continue;
    text += " " + (word.find(' ') == std::string::npos ? word : "'" + word + "'");
  }
  return text;
}

Result<sim::ComputePrices> pricesOf(const ExperimentArguments& args) {
  if (args.calibration.empty()) return sim::ComputePrices{};
  return sim::readPrices(args.calibration);
}

nlohmann::ordered_json aboutExperiment(const ExperimentArguments& args, const sim::ComputePrices& prices) {
  return {{"command", args.command},
          {"seed", args.seed},
          {"version", FORELAND_VERSION},
          {"calibration", prices.name},
          {"prices", apps::toJson(prices)}};
}

nlohmann::ordered_json askedOf(nlohmann::ordered_json about, const terrain::Scene& scene) {
  about.erase("command");
  about["scene_id"] = scene.id();
  about["protocol"] = proto::kProtocolVersion;
  return about;
}

Progress::Progress(size_t count) : count_(count), is_shown_(isatty(STDERR_FILENO) == 1) {}

void Progress::show(size_t done) const {
  if (!is_shown_ || done == 0) return;
  const std::chrono::duration<double> spent = std::chrono::steady_clock::now() - begin_;
  const double left_s = spent.count() / static_cast<double>(done) * static_cast<double>(count_ - done);
  std::fprintf(stderr, "\r%zu of %zu, %.0f s left   ", done, count_, left_s);
}

Progress::~Progress() {
  if (is_shown_) std::fputs("\n", stderr);
}

}  // namespace foreland::apps
