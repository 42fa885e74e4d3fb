#include "lab/load/load_programs.h"

#include <array>

namespace foreland::lab {

namespace {

using Json = AskedProgram::Json;

Json jsonOf(std::span<const ServerLoad> servers) {
  Json all = Json::array();
  for (const ServerLoad& s : servers) all.push_back({{"open", s.is_open}, {"used", s.used}, {"pausing", s.is_pausing}});
  return all;
}

Json jsonOf(std::span<const ViewerLoad> viewers) {
  Json all = Json::array();
  for (const ViewerLoad& v : viewers)
    all.push_back({{"server", v.server}, {"used", v.used}, {"movable", v.is_movable}, {"resume_s", v.resume_s}});
  return all;
}

class ToldBalancer final : public Balancer {
 public:
  explicit ToldBalancer(AskedProgram& program) : program_(program) {
    queues_ = program.greeting().value("queues", Json()) == true;
    moves_ = program.greeting().value("moves", Json()) == true;
  }

  std::optional<size_t> place(std::span<const ServerLoad> servers, const Arrival& arrival) override {
    const auto answer = program_.ask({{"ask", "place"},
                                      {"time_us", arrival.now.us},
                                      {"turn", arrival.turn},
                                      {"resuming", arrival.is_resuming},
                                      {"servers", jsonOf(servers)}});
    if (!answer || (answer->contains("server") && (*answer)["server"].is_null())) return std::nullopt;
    return openServer(*answer, "server", servers);
  }

  bool queuesResumed() const override { return queues_; }

  std::optional<Move> move(std::span<const ServerLoad> servers, std::span<const ViewerLoad> viewers,
                           Time now) override {
    if (!moves_ || viewers.empty()) return std::nullopt;
    const auto answer = program_.ask(
        {{"ask", "move"}, {"time_us", now.us}, {"servers", jsonOf(servers)}, {"viewers", jsonOf(viewers)}});
    if (!answer || (answer->contains("viewer") && (*answer)["viewer"].is_null())) return std::nullopt;
    const auto viewer = program_.whole(*answer, "viewer", 0, static_cast<int64_t>(viewers.size()) - 1);
    if (!viewer) return std::nullopt;
    const auto to = openServer(*answer, "to", servers);
    if (!to) return std::nullopt;
    const ViewerLoad& moved = viewers[static_cast<size_t>(*viewer)];
    if (moved.is_movable && moved.server != *to) return Move{static_cast<size_t>(*viewer), *to};
    (void)program_.refuse("viewer " + std::to_string(*viewer) + " cannot be moved, or is there already");
    return std::nullopt;
  }

 private:
  std::optional<size_t> openServer(const Json& answer, const char* name, std::span<const ServerLoad> servers) {
    const auto server = program_.whole(answer, name, 0, static_cast<int64_t>(servers.size()) - 1);
    if (!server) return std::nullopt;
    if (servers[static_cast<size_t>(*server)].is_open) return static_cast<size_t>(*server);
    (void)program_.refuse("server " + std::to_string(*server) + " takes no viewers");
    return std::nullopt;
  }

  AskedProgram& program_;
  bool queues_ = false, moves_ = false;
};

class ToldOrder final : public JobOrder {
 public:
  explicit ToldOrder(AskedProgram& program) : program_(program) {}
  server::JobKey key() const override { return server::toldKey; }

  void place(server::Due& job, const JobOwner& owner, Time now) override {
    const auto answer = program_.ask({{"ask", "key"},
                                      {"time_us", now.us},
                                      {"viewer", owner.viewer},
                                      {"release_us", job.release.us},
                                      {"deadline_us", job.deadline.us},
                                      {"work_us", job.work.us},
                                      {"costly", job.is_costly},
                                      {"owed_s", owner.deficit.seconds()},
                                      {"share", owner.share}});
    if (!answer) return;
    constexpr int64_t kMost = int64_t{1} << 62;
    if (const auto key = program_.whole(*answer, "key", -kMost, kMost); key.ok()) job.key = {*key};
  }

 private:
  AskedProgram& program_;
};

}  // namespace

Result<LoadPrograms> LoadPrograms::start(const LoadOptions& options) {
  LoadPrograms programs;
  struct Wanted {
    const char* asked;
    const std::string& command;
    std::unique_ptr<AskedProgram>& program;
  };
  const std::array<Wanted, 4> all{Wanted{"balance", options.cluster.balance_command, programs.balance},
                                  Wanted{"order", options.order_command, programs.order},
                                  Wanted{"predictor", options.predictor_command, programs.predictor},
                                  Wanted{"link", options.link_command, programs.link}};
  for (const Wanted& wanted : all) {
    if (wanted.command.empty()) continue;
    auto program = AskedProgram::start({"--" + std::string(wanted.asked) + "-command", wanted.asked}, wanted.command,
                                       options.seed);
    if (!program) return program.error();
    wanted.program = std::move(*program);
  }
  return programs;
}

Status LoadPrograms::status() const {
  for (const auto* program : {&balance, &order, &predictor, &link})
    if (*program && !(*program)->status().ok()) return (*program)->status();
  return {};
}

std::unique_ptr<Balancer> toldBalancer(AskedProgram& program) { return std::make_unique<ToldBalancer>(program); }
std::unique_ptr<JobOrder> toldOrder(AskedProgram& program) { return std::make_unique<ToldOrder>(program); }

}  // namespace foreland::lab
