#include "lab/apps/bench_load.h"

#include <cstdio>

#include "apps/options/options.h"
#include "lab/apps/bench_flight.h"
#include "lab/load/real_load.h"
#include "lab/tables.h"

namespace foreland::apps {

namespace {

std::string lineOf(const nlohmann::ordered_json& row) {
  const auto number = [&](const char* key) { return row[key].get<double>(); };
  char text[300];
  if (row.contains("balance")) {
    std::snprintf(
        text, sizeof text,
        "%-12s %5.2f %% of %.0f not in time, used %.2f, imbalance %.2f; connected again %.0f moved, %.0f handed "
        "over, %.0f lost; gap p50 %.0f and %.0f ms; %.1f kB up, %.1f kB down",
        row["balance"].get<std::string>().c_str(), 100 * number("not_in_time_share"), number("asked"),
        number("utilisation"), number("imbalance"), number("moves"), number("handed_over"), number("lost"),
        number("move_gap_p50_ms"), number("lost_gap_p50_ms"), 1e-3 * number("move_up_mean_bytes"),
        1e-3 * number("move_down_mean_bytes"));
    return text;
  }
  std::snprintf(text, sizeof text,
                "%-12s %-12s %-5s +%.0f ms %-8s %4.0f viewers: %6.2f %% of %.0f missed, lateness p99 %7.2f ms, used "
                "%.2f (peak %.2f), "
                "Jain %.3f",
                row["policy"].get<std::string>().c_str(), row["phases"].get<std::string>().c_str(),
                row["start"].get<std::string>().c_str(), number("slack_ms"), row["queues"].get<std::string>().c_str(),
                number("viewers"), 100 * number("missed_share"), number("keyframes"), number("lateness_p99_ms"),
                number("utilisation"), number("utilisation_peak"), number("jain"));
  return text;
}

// How many of the numbers of viewers that were tried are served.
std::string capacityLine(const nlohmann::ordered_json& way) {
  std::string text;
  for (const auto& [key, value] : way.items())
    if (key != "most_viewers" && key != "fewest_missing")
      text += (value.is_string() ? value.get<std::string>() : "+" + lab::numberText(value.get<double>()) + " ms") + " ";
  return text + std::to_string(way["most_viewers"].get<size_t>()) + " viewers miss under 0.1 % of their deadlines";
}

// Searches run one after another on each thread, so that the most viewers of each is found on its own.
Status search(const std::shared_ptr<const server::World>& world, std::vector<lab::LoadOptions>& runs) {
  for (lab::LoadOptions& run : runs) {
    const auto most = lab::maxViewers(world, run);
    if (!most) return most.error();
    run.viewers = std::max<size_t>(1, *most);
  }
  return {};
}

// One number as such, several as a list.
nlohmann::ordered_json viewersAsked(const lab::LoadRequest& request) {
  if (request.viewers.size() == 1) return request.viewers.front();
  return request.viewers;
}

uint64_t digestOf(const sim::LinkPair& links) {
  Fnv1a hash;
  addRecordings(links, hash);
  return hash.value();
}

// The tables, if there is a folder for them; of several numbers of viewers with what they come to.
Status keep(const std::filesystem::path& out, nlohmann::ordered_json about, const std::vector<lab::CellTables>& tables,
            const std::vector<nlohmann::ordered_json>& capacities) {
  if (out.empty()) return {};
  if (!capacities.empty()) {
    about["capacity"] = capacities;
    if (Status s = lab::writeFile(out, "capacity.csv", lab::capacityCsv(capacities)); !s.ok()) return s;
  }
  return lab::writeCells(out, about, lab::kLoadNames, tables);
}

// Both worlds and their differences, a line or an object for each figure.
nlohmann::ordered_json rowsOf(const std::vector<lab::Agreement>& all, apps::ReportFormat format) {
  auto rows = nlohmann::ordered_json::array();
  for (const lab::Agreement& a : all) {
    nlohmann::ordered_json row{{"figure", a.name},
                               {"virtual", lab::rounded(a.virtual_time)},
                               {"real", lab::rounded(a.real_time)},
                               {"difference", lab::rounded(a.difference())},
                               {"ratio", nullptr}};
    if (a.virtual_time != 0) row["ratio"] = lab::rounded(a.real_time / a.virtual_time);
    char line[200];
    std::snprintf(line, sizeof line, "%-22s virtual %10.2f, real %10.2f, difference %+9.2f", a.name, a.virtual_time,
                  a.real_time, a.difference());
    rows.push_back(format == apps::ReportFormat::kJson ? row : nlohmann::ordered_json(line));
  }
  return rows;
}

// What each viewer got in either.
nlohmann::ordered_json viewersOf(const lab::LoadRun& virtual_time, const lab::RealLoad& real_time) {
  auto viewers = nlohmann::ordered_json::array();
  for (size_t i = 0; i < real_time.viewers.size(); ++i) {
    const lab::ViewerTally &a = virtual_time.viewers[i], &b = real_time.viewers[i];
    viewers.push_back({{"virtual_keyframes", a.keyframes},
                       {"real_keyframes", b.keyframes},
                       {"virtual_bytes", a.bytes},
                       {"real_bytes", b.bytes}});
  }
  return viewers;
}

std::filesystem::path besideThisProgram(const char* name) {
  std::error_code ignored;
  return std::filesystem::read_symlink("/proc/self/exe", ignored).parent_path() / name;
}

// The one run, in virtual and in real time.
Result<nlohmann::ordered_json> loadInBoth(const std::shared_ptr<const server::World>& world, const LoadArguments& args,
                                          const lab::LoadOptions& run, nlohmann::ordered_json about) {
  const lab::LoadRun virtual_time = lab::runLoad(world, run);
  const auto real_time =
      lab::runRealLoad(world->hierarchy.scene(), run, besideThisProgram("foreland-serve"), args.scene);
  if (!real_time) return real_time.error();
  const auto all = lab::agreementOf(virtual_time, *real_time);
  about.update(lab::askedBy(run));
  about["largest_byte_difference"] = lab::rounded(lab::largestByteDifference(virtual_time, *real_time));
  if (!args.experiment.out.empty()) {
    nlohmann::ordered_json kept = about;
    kept["agreement"] = rowsOf(all, apps::ReportFormat::kJson);
    kept["viewers"] = viewersOf(virtual_time, *real_time);
    if (Status s = lab::writeFile(args.experiment.out, "agreement.json", kept.dump(2) + "\n"); !s.ok())
      return s.error();
  }
  about["agreement"] = rowsOf(all, args.format);
  return about;
}

const std::string& orOwn(const std::string& command, const std::string& own) { return command.empty() ? own : command; }

constexpr const char* kCompared = "What is compared";

void addViewerOptions(CLI::App& sub, LoadArguments& args) {
  lab::LoadRequest& request = args.request;
  request.viewers = {request.base.viewers};
  sub.add_option("--viewers", request.viewers,
                 "how many; of several numbers, such as 50,100,200, each in turn; the first guess of --most-viewers")
      ->delimiter(',')
      ->type_name(whole("N"))
      ->check(within(1, 4096))
      ->capture_default_str();
  sub.add_option("--workers", request.base.workers, "of the server")
      ->type_name(whole("N"))
      ->check(within(1, 64))
      ->capture_default_str();
  sub.add_option("--mix", args.mix, "what the viewers do")
      ->check(oneOf({"mixed", "tours", "survey"}))
      ->capture_default_str();
  sub.add_option("--predictor", args.predictor, "of viewers who do not jump")
      ->type_name(text("NAME"))
      ->check(oneOf({"hold", "velocity", "acceleration", "double-exponential", "kalman", "path"}))
      ->capture_default_str();
  sub.add_option("--predictor-command", request.base.predictor_command,
                 "a program in place of --predictor (docs/INSTRUMENT.md)")
      ->type_name(text("COMMAND"))
      ->excludes("--predictor");
  sub.add_option("--occlusion", args.occlusion,
                 "on: what ridges hide is not sent; auto: as long as that pays (foreland serve --help)")
      ->check(oneOf({"off", "auto", "on"}))
      ->capture_default_str();
  addLinkOptions(sub, args.link, "fixed");
  sub.add_option("--link-command", request.base.link_command, "a program in place of --link (docs/INSTRUMENT.md)")
      ->type_name(text("COMMAND"))
      ->excludes("--link");
}

// Every combination of these is run.
void addComparedOptions(CLI::App& sub, lab::LoadRequest& request) {
  const auto add = [&](const char* name, auto& values, const char* what) {
    return sub.add_option(name, values, what)->delimiter(',')->group(kCompared);
  };
  add("--policies", request.policies, "which job a worker takes next; by default all")
      ->type_name(text("NAMES"))
      ->check(oneOf({"fifo", "edf", "least-laxity", "fair"}));
  sub.add_option("--order-command", request.order_command, "one more policy, which is a program (docs/INSTRUMENT.md)")
      ->type_name(text("COMMAND"))
      ->group(kCompared);
  add("--phases", request.phases, "when the viewers' keyframes are due; by default all")
      ->type_name(text("NAMES"))
      ->check(oneOf({"synchronised", "random", "staggered"}));
  add("--starts", request.starts, "by when keyframes are begun; by default both")
      ->type_name(text("NAMES"))
      ->check(oneOf({"late", "early"}));
  add("--slack-ms", request.slacks_ms,
      "with early starts: begin keyframes so much sooner than they are expected to need; by default as servers")
      ->type_name(number("MS"))
      ->check(within(0.0, 1000.0))
      ->capture_default_str();
  add("--queues", request.queues,
      "one queue for all workers, or one for each, from which idle workers steal; by default shared")
      ->type_name(text("NAMES"))
      ->check(oneOf({"shared", "stealing"}));
}

void addClusterOptions(CLI::App& sub, lab::LoadRequest& request) {
  const std::string group = "Several servers";
  const auto add = [&](const char* name, auto& values, const char* what) {
    return sub.add_option(name, values, what)->delimiter(',')->group(group);
  };
  sub.add_option("--servers", request.base.cluster.servers, "with so many --workers each")
      ->type_name(whole("N"))
      ->check(within(1, 64))
      ->capture_default_str()
      ->group(group);
  add("--balance", request.balances, "how viewers are shared among servers; by default all, of several servers")
      ->type_name(text("NAMES"))
      ->check(oneOf({"random", "round-robin", "least-loaded", "two-choices", "migrate"}));
  sub.add_option("--balance-command", request.balance_command,
                 "one more balance, which is a program (docs/INSTRUMENT.md)")
      ->type_name(text("COMMAND"))
      ->group(group);
  add("--fail", request.fails, "a server fails")->type_name(text("SERVER@SECONDS"));
  add("--drain", request.drains, "a server hands its viewers over")->type_name(text("SERVER@SECONDS"));
  add("--join", request.joins, "a server is added, or is there again")->type_name(text("SERVER@SECONDS"));
}

void addDisturbances(CLI::App& sub, lab::LoadRequest& request) {
  sub.add_option("--neighbour", request.base.neighbour,
                 "somebody else takes this share of the processors' time, in the first half second of each two")
      ->type_name(number("SHARE"))
      ->check(within(0.0, 0.95))
      ->capture_default_str();
  sub.add_option("--crowd-jump", request.base.crowd_jump_s,
                 "all viewers jump elsewhere each so many seconds, within one keyframe interval; 0: never")
      ->type_name(number("S"))
      ->check(within(0.0, 3600.0))
      ->capture_default_str();
}

void addTimeOptions(CLI::App& sub, lab::LoadRequest& request) {
  sub.add_option("--seconds", request.base.seconds, "measured")
      ->type_name(number("S"))
      ->check(within(1.0, 3600.0))
      ->capture_default_str();
  sub.add_option("--run-in", request.base.run_in_s,
                 "seconds before, in which viewers come and get their first sections")
      ->type_name(number("S"))
      ->check(within(2.0, 600.0))
      ->capture_default_str();
  CLI::Option* step =
      sub.add_option("--before-step", request.base.before_step,
                     "so many of the viewers come in the run-in, the others when what is measured begins")
          ->type_name(whole("N"))
          ->check(within(1, 4096));
  sub.add_option("--step", request.base.step_s, "seconds in which these others come")
      ->type_name(number("S"))
      ->check(within(0.0, 600.0))
      ->needs(step)
      ->capture_default_str();
  sub.add_option("--tau", request.base.tau_px, "tolerance in pixels")
      ->type_name(number("PX"))
      ->check(within(0.05, 1000.0))
      ->capture_default_str();
  sub.add_option("--keyframe-ms", request.base.keyframe_ms, "keyframe interval")
      ->type_name(number("MS"))
      ->check(within(20.0, 10'000.0))
      ->capture_default_str();
}

}  // namespace

CLI::App* addLoad(CLI::App& app, LoadArguments& args) {
  CLI::App* sub = app.add_subcommand("load", "many viewers on few workers, in virtual time");
  sub->add_option("SCENE", args.scene, "scene file (`foreland build`)")->type_name(file("SCENE.fls"))->required();
  addViewerOptions(*sub, args);
  addComparedOptions(*sub, args.request);
  addClusterOptions(*sub, args.request);
  addTimeOptions(*sub, args.request);
  addDisturbances(*sub, args.request);
  sub->add_flag_callback(
      "--most-viewers", [&args] { args.search = Search::kMaxViewers; },
      "find the largest number of viewers with under 0.1 % missed, for each run");
  sub->add_flag_callback(
      "--real", [&args] { args.in_time = InTime::kBoth; },
      "run it in real time as well, with `foreland serve` on loopback, and say by how much the two differ (fair, "
      "early; "
      "staggered if no --phases is given)");
  sub->add_flag_callback(
      "--json", [&args] { args.format = apps::ReportFormat::kJson; }, "print JSON");
  addExperimentOptions(*sub, args.experiment);
  return sub;
}

namespace {

// With what several options say together.
Result<lab::LoadRequest> requestOf(const LoadArguments& args) {
  lab::LoadRequest request = args.request;
  const auto mix = lab::mixNamed(args.mix);
  if (!mix) return mix.error();
  const auto prices = pricesOf(args.experiment);
  if (!prices) return prices.error();
  const auto predictor = proto::predictorNamed(args.predictor);
  if (!predictor)
    return Error{ErrorCode::kInvalidArgument,
                 "--predictor '" + args.predictor + "': choose one of " + proto::predictorNames()};
  if (*predictor == proto::Predictor::kKnownPath && request.base.cluster.servers > 1)
    return Error{ErrorCode::kInvalidArgument, "--predictor path: viewers of several servers announce no path"};
  if (*predictor == proto::Predictor::kKnownPath && request.base.crowd_jump_s > 0)
    return Error{ErrorCode::kInvalidArgument, "--predictor path: a crowd that jumps (--crowd-jump) announces no path"};
  if (args.in_time == InTime::kBoth) {
    if (request.policies.empty()) request.policies = {"fair"};
    if (request.phases.empty()) request.phases = {"staggered"};
    if (request.starts.empty()) request.starts = {"early"};
    if (request.balances.empty() && request.base.cluster.servers > 1) request.balances = {"round-robin"};
  }
  const auto links = linksOf(args.link);
  if (!links) return links.error();
  request.base.viewers = request.viewers.front();
  request.base.links = *links;
  request.base.occlusion = *server::occlusionNamed(args.occlusion);
  request.base.predictor = *predictor;
  request.base.mix = *mix;
  request.base.prices = *prices;
  request.base.seed = args.experiment.seed;
  return request;
}

Status checkBoth(const LoadArguments& args, const std::vector<lab::LoadOptions>& runs) {
  if (args.search == Search::kMaxViewers && args.request.viewers.size() > 1)
    return Error{ErrorCode::kInvalidArgument, "--most-viewers searches from one number of --viewers, not from several"};
  if (args.in_time == InTime::kVirtual) return {};
  if (args.search == Search::kMaxViewers)
    return Error{ErrorCode::kInvalidArgument, "--real runs one load; --most-viewers would run many"};
  for (const lab::LoadOptions& run : runs)
    if (Status s = lab::checkReal(run); !s.ok()) return Error{s.error().code, "--real: " + s.error().message};
  if (runs.size() == 1) return {};
  return Error{ErrorCode::kInvalidArgument,
               "--real runs one load, not " + std::to_string(runs.size()) + "; give one of --phases and of --viewers"};
}

}  // namespace

Status checkArguments(const LoadArguments& args) {
  const auto request = requestOf(args);
  if (!request) return request.error();
  const auto runs = lab::runsOf(*request);
  return runs ? checkBoth(args, *runs) : runs.error();
}

Result<nlohmann::ordered_json> load(const LoadArguments& args) {
  const auto asked = requestOf(args);
  if (!asked) return asked.error();
  const lab::LoadRequest& request = *asked;
  auto runs = lab::runsOf(request);
  if (!runs) return runs.error();
  if (Status s = checkBoth(args, *runs); !s.ok()) return s.error();
  const auto scene = terrain::Scene::open(args.scene);
  if (!scene) return scene.error();
  const auto opened = server::openWorld(*scene, request.base.occlusion);
  if (!opened) return opened.error();
  const std::shared_ptr<const server::World>& world = *opened;

  if (args.search == Search::kMaxViewers)
    if (Status s = search(world, *runs); !s.ok()) return s.error();
  nlohmann::ordered_json about{{"experiment", "load"}};
  about.update(aboutExperiment(args.experiment, request.base.prices));
  about.update({{"scene", std::filesystem::path(args.scene).filename().string()},
                {"viewers", viewersAsked(request)},
                {"workers", request.base.workers},
                {"mix", args.mix},
                {"predictor", orOwn(request.base.predictor_command, args.predictor)},
                {"link", orOwn(request.base.link_command, args.link.link)},
                {"occlusion", args.occlusion},
                {"seconds", request.base.seconds},
                {"run_in_s", request.base.run_in_s},
                {"before_step", request.base.before_step},
                {"step_s", request.base.step_s},
                {"neighbour", request.base.neighbour},
                {"crowd_jump_s", request.base.crowd_jump_s},
                {"tau_px", request.base.tau_px},
                {"keyframe_ms", request.base.keyframe_ms}});
  if (request.base.cluster.servers > 1)
    about.update({{"servers", request.base.cluster.servers},
                  {"fail", request.fails},
                  {"drain", request.drains},
                  {"join", request.joins}});
  if (args.in_time == InTime::kBoth) return loadInBoth(world, args, runs->front(), about);
  const Progress progress(runs->size());
  nlohmann::ordered_json shared = askedOf(about, **scene);
  if (args.link.link == "trace") shared["recorded"] = digestOf(request.base.links);
  const auto tables = lab::runAll(world, *runs, shared, lab::KeptCells(args.experiment.cells), args.experiment.threads,
                                  [&](size_t done) { progress.show(done); });
  if (!tables) return tables.error();
  const std::vector<nlohmann::ordered_json> capacities = lab::capacitiesOf(*tables);
  if (Status s = keep(args.experiment.out, about, *tables, capacities); !s.ok()) return s.error();
  nlohmann::ordered_json summary = about;
  summary["runs"] = nlohmann::ordered_json::array();
  for (const lab::CellTables& cell : *tables)
    summary["runs"].push_back(args.format == apps::ReportFormat::kJson ? cell.row
                                                                       : nlohmann::ordered_json(lineOf(cell.row)));
  for (const nlohmann::ordered_json& way : capacities)
    summary["capacity"].push_back(args.format == apps::ReportFormat::kJson ? way
                                                                           : nlohmann::ordered_json(capacityLine(way)));
  return summary;
}

}  // namespace foreland::apps
