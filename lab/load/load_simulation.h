// Servers, viewers and links of one load in virtual time: an event queue over real sessions and the server's own queue
// of jobs. Private to lab/load; one owner.
#pragma once

#include <deque>
#include <functional>
#include <memory>
#include <optional>
#include <queue>
#include <span>
#include <vector>

#include "lab/load/job_order.h"
#include "lab/load/light_viewer.h"
#include "lab/load/load_cast.h"
#include "lab/load/load_programs.h"
#include "lab/load/load_run.h"
#include "lab/load/worker_queues.h"
#include "server/net/metrics/load.h"
#include "server/sched/deficit.h"
#include "server/session/session.h"
#include "sim/link.h"

namespace foreland::lab {

// How often a balancer looks at its servers.
inline constexpr Duration kBalanceEvery = Duration::milliseconds(250);

class LoadSimulation {
 public:
  // `programs` outlives this.
  LoadSimulation(std::shared_ptr<const server::World> world, const LoadOptions& options, LoadPrograms& programs);

  void run();
  LoadRun result() const;

 private:
  struct Server {
    Server(const LoadOptions& options, server::JobKey keyOf, size_t bins);
    WorkerQueues queues;
    std::vector<bool> is_free;  // by worker
    size_t costly_running = 0;
    bool is_up = true, is_open = true;  // open: takes viewers
    std::optional<Time> wake;
    ResumePace resumes;
    std::unique_ptr<server::Load> load;
    std::vector<int64_t> busy_us;  // by bin
  };
  struct Viewer {
    Viewer(const LoadViewer& viewer, LightViewer::Holds holds);
    LightViewer light;
    sim::LinkPair links;
    sim::Link up, down;
    Rng seeds;
    Duration clock;  // the viewer's less the server's
    bool is_jumper;
    ViewerTally tally;

    // Of the connection; `session` is null while there is none.
    size_t server = 0;
    uint32_t connection = 0;
    std::unique_ptr<server::Session> session;
    std::deque<Bytes> inbox;
    bool is_running = false, is_queued = false, waits_for_drain = false;
    WorkerQueues::Ticket ticket;
    server::Deficit deficit;

    // Of the step that runs.
    std::vector<Bytes> out;
    Duration work;
    Time deadline;
    size_t worker = 0;
    bool is_keyframe = false, has_deadline = false, is_costly = false;
    uint64_t in_time = 0;  // keyframes
    double cost = 0;       // of one worker's time, as the server sees it
    Time charged_at;

    // Of moving. `leaving`: a step still runs. `closing`: the end of the connection is on its way, behind all else.
    std::optional<MoveCause> leaving, closing, moving;
    std::optional<size_t> goes_to;  // as the balancer chose
    Time connected_at;
    std::optional<Time> last_keyframe_at;
    ViewerMove move;
    Duration resume_work;         // that reading what it holds and a keyframe take, as its last server knew
    double used_s = 0, load = 0;  // since the last look; of one worker, lately
    bool is_known = false;        // to the balancer
  };
  enum class What : uint8_t {
    kPose,
    kUp,
    kDown,
    kDrained,
    kDone,
    kWake,
    kConnect,
    kServer,
    kMigrate,
    kBalance,
    kAdmit
  };
  struct Event {
    Time at;
    uint64_t sequence;
    What what;
    size_t index;             // of the viewer, of the server (kWake) or of the server event (kServer)
    uint32_t connection = 0;  // that it belongs to
    bool operator<(const Event& o) const { return std::pair(o.at, o.sequence) < std::pair(at, sequence); }
  };

  bool isCluster() const { return options_.cluster.servers > 1; }
  void at(Time t, What what, size_t index, uint32_t connection = 0) {
    events_.push({t, next_sequence_++, what, index, connection});
  }
  void addViewers(const std::shared_ptr<const server::World>& world);
  void addClusterEvents();
  void send(size_t i, Bytes message, Time t);

  void handle(const Event& event);
  void handleConnection(const Event& event);
  void receive(size_t i);
  void take(size_t i);
  void schedule(size_t i);
  void startJobs(size_t server);
  bool startJob(Server& server);
  void step(size_t i, size_t worker);
  void done(size_t i);
  void count(Viewer& v);
  void use(Server& server, Time from, Time to);

  // load_cluster.cpp: connections that move from server to server.
  void connect(size_t i);
  std::optional<size_t> serverFor(size_t i);
  void wait(size_t i);
  void admit();
  void pace(size_t server, const Viewer& v);
  void leave(size_t i, MoveCause cause);
  void lose(size_t i);
  void close(size_t i);
  void connectLater(size_t i, Duration wait);
  void arrived(Viewer& v, const LightViewer::Received& keyframe, size_t bytes);
  void change(const ServerEvent& event);
  void drain(size_t server);
  void balance();
  void look(std::span<const ServerLoad> expected);
  void observeLoads();
  double expectedLoad(const Viewer& v) const { return v.is_known ? v.load : mean_load_; }
  Duration resumeWork(const Viewer& v) const;
  ViewerLoad loadOf(const Viewer& v) const;
  std::vector<ServerLoad> serverLoads() const;

  double share() const;
  // As servers do after each step: notes what it took, and rations what the next ones may.
  void charge(Viewer& v, Server& server);
  bool isMeasured() const { return now_ >= begin_ && now_ < end_; }
  double fairness() const;
  void addVariability(LoadFigures& figures) const;
  Duration slowed(Duration work) const;
  void noteDue(Time due, Duration work);
  void addClusterResult(LoadRun& run) const;

  std::shared_ptr<const server::World> world_;
  LoadOptions options_;
  server::SessionOptions session_options_;
  Time begin_, end_, now_;
  server::SessionScratch scratch_;
  std::vector<Server> servers_;
  std::vector<std::unique_ptr<Viewer>> viewers_;
  std::priority_queue<Event> events_;
  uint64_t next_sequence_ = 0;

  LoadPrograms& programs_;
  std::unique_ptr<JobOrder> order_;
  std::unique_ptr<Balancer> balancer_;
  std::function<std::unique_ptr<server::Foresight>()> foresee_;  // of viewers who do not jump; empty: their predictors
  Rng balancing_;  // chance of the balancer and of viewers who wait before they connect again
  size_t turn_ = 0;
  double mean_load_ = 0;
  std::vector<size_t> waiting_;  // viewers who resume, with `migrate`
  double imbalance_ = 0;         // sum over looks
  uint64_t looks_ = 0;
  std::vector<ViewerMove> moves_;
  std::vector<uint64_t> in_time_;  // keyframes, by kClusterBin
  std::vector<ServerLook> looks_taken_;

  std::vector<double> lateness_ms_, work_ms_, at_once_ms_;
  std::vector<int64_t> due_us_;  // work by the whole keyframe interval in which it falls due
  sim::StepWork work_;
  LoadFigures figures_;
  uint64_t received_ = 0;  // keyframes, at viewers
};

}  // namespace foreland::lab
