#include "bench/load/load_run.h"

#include <algorithm>
#include <cmath>
#include <deque>
#include <queue>

#include "bench/load/light_viewer.h"
#include "bench/timing.h"
#include "bench/world/link_models.h"
#include "server/sched/deadline_queue.h"
#include "server/sched/debt.h"
#include "server/view/tour.h"

namespace foreland::bench {

namespace {

using server::Session;

constexpr double kTour_s = 60;

server::JobOrder orderOf(LoadPolicy policy) {
  if (policy == LoadPolicy::kFifo) return server::JobOrder::kRelease;
  return policy == LoadPolicy::kLeastLaxity ? server::JobOrder::kLaxity : server::JobOrder::kDeadline;
}

struct Tours {
  explicit Tours(const terrain::Scene& scene)
      : survey(of(scene, "survey")), canyon(of(scene, "canyon")), spin(of(scene, "spin")) {}
  std::shared_ptr<const proto::Path> survey, canyon, spin;

 private:
  static std::shared_ptr<const proto::Path> of(const terrain::Scene& scene, const char* tour) {
    return std::make_shared<const proto::Path>(server::planTour(scene, tour, kTour_s).value());
  }
};

struct Cast {
  LightViewer::Flight flight;
  proto::ViewRequest request;
  LinkPair links = fixedLink(Duration::milliseconds(50));
};

// The role of viewer `i`.
Cast castOf(const Tours& tours, const LoadOptions& options, size_t i, Rng& chance) {
  const Duration offset = Duration::seconds(chance.uniform(0, kTour_s));
  Cast cast{.flight = {tours.survey, offset, {}}, .request = {}};
  cast.request.tau_px = options.tau_px;
  cast.request.strategy = proto::Strategy::kPredict;
  cast.request.predictor = proto::Predictor::kConstantVelocity;
  cast.request.keyframe_interval = Duration::seconds(1e-3 * options.keyframe_ms);
  if (options.mix == Mix::kSurvey) return cast;
  const size_t role = i % 20;
  if (role >= 8 && role < 15) cast.flight.path = tours.canyon;
  if (role == 15 || role == 16) cast.flight.path = tours.spin;
  if (role == 17) cast.flight.jump_every = Duration::seconds(4);
  if (role == 18) cast.links.down.bytes_per_second = 256e3 / 8;
  if (role == 19) {
    cast.request.tau_px = options.tau_px / 4;
    cast.request.lens = {1.0471975511965976, 3840, 2160};
  }
  return cast;
}

class Simulation {
 public:
  Simulation(const std::shared_ptr<const server::World>& world, const LoadOptions& options)
      : options_(options),
        begin_(Time{} + kLoadRunIn),
        end_(begin_ + Duration::seconds(options.seconds)),
        queue_(options.workers, orderOf(options.policy)),
        free_workers_(options.workers),
        busy_us_(static_cast<size_t>((end_ - begin_).us / kUtilisationBin.us) + 1) {
    server::SessionOptions session;
    if (options.start == LoadStart::kEarly) session.most_early = Duration::seconds(0.5e-3 * options.keyframe_ms);
    const Tours tours(world->hierarchy.scene());
    Rng chance(options.seed);
    for (size_t i = 0; i < options.viewers; ++i)
      viewers_.push_back(std::make_unique<Viewer>(castOf(tours, options, i, chance), world, session, chance.next()));
    for (size_t i = 0; i < options.viewers; ++i) begin(i, chance);
  }

  void run() {
    while (!events_.empty() && events_.top().at <= end_) {
      const Event event = events_.top();
      events_.pop();
      now_ = std::max(now_, event.at);
      handle(event);
      startJobs();
    }
  }

  LoadRun result() const;

 private:
  struct Viewer {
    Viewer(Cast cast, std::shared_ptr<const server::World> world, const server::SessionOptions& o, uint64_t seed)
        : light(cast.request, cast.flight),
          session(std::move(world), o),
          up(cast.links.up, seed),
          down(cast.links.down, seed + 1) {}
    LightViewer light;
    Session session;
    Link up, down;
    Duration clock;  // the viewer's less the server's
    std::deque<Bytes> inbox;
    bool is_running = false, is_queued = false, waits_for_drain = false;
    server::DeadlineQueue::Ticket ticket;
    server::Debt debt;
    // Of the step that runs.
    std::vector<Bytes> out;
    Duration work;
    Time deadline;
    bool is_keyframe = false, has_deadline = false;
    uint64_t in_time = 0;  // keyframes
  };
  enum class What : uint8_t { kPose, kUp, kDown, kDrained, kDone, kWake };
  struct Event {
    Time at;
    uint64_t sequence;
    What what;
    size_t viewer;
    bool operator<(const Event& o) const { return std::pair(o.at, o.sequence) < std::pair(at, sequence); }
  };

  void at(Time t, What what, size_t viewer) { events_.push({t, next_sequence_++, what, viewer}); }

  // Viewers come one after another within a second; their phases follow from their clocks.
  void begin(size_t i, Rng& chance) {
    Viewer& v = *viewers_[i];
    const auto interval_us = static_cast<double>(v.light.request().keyframe_interval.us);
    const double share = static_cast<double>(i) / static_cast<double>(options_.viewers);
    if (options_.phases == Phases::kRandom) v.clock = Duration{static_cast<int64_t>(chance.uniform(0, interval_us))};
    if (options_.phases == Phases::kStaggered) v.clock = Duration{static_cast<int64_t>(share * interval_us)};
    const Time comes = Time::seconds(share);
    send(i, v.light.hello(), comes);
    at(comes + Duration{1000}, What::kPose, i);
  }

  void send(size_t i, Bytes message, Time t) {
    viewers_[i]->up.send(std::move(message), t);
    at(*viewers_[i]->up.newestArrival(), What::kUp, i);  // messages arrive in order, and each has an event
  }

  void handle(const Event& event);
  void take(size_t i);
  void schedule(size_t i);
  void startJobs();
  void step(size_t i);
  void done(size_t i);
  void count(Viewer& v);
  void use(Time from, Time to);
  double share() const { return 0.85 * static_cast<double>(options_.workers) / static_cast<double>(options_.viewers); }
  bool isMeasured() const { return now_ >= begin_ && now_ < end_; }

  LoadOptions options_;
  Time begin_, end_, now_;
  server::DeadlineQueue queue_;
  size_t free_workers_;
  server::SessionScratch scratch_;
  std::vector<std::unique_ptr<Viewer>> viewers_;
  std::priority_queue<Event> events_;
  uint64_t next_sequence_ = 0;
  std::optional<Time> wake_;

  std::vector<int64_t> busy_us_;  // by bin
  std::vector<double> lateness_ms_, work_ms_;
  StepWork work_;
  LoadFigures figures_;
};

void Simulation::handle(const Event& event) {
  const size_t i = event.viewer;
  if (event.what == What::kWake) {
    wake_.reset();
    return;
  }
  Viewer& v = *viewers_[i];
  if (event.what == What::kPose) {
    send(i, v.light.pose(now_ + v.clock), now_);
    at(now_ + LightViewer::kPoseInterval, What::kPose, i);
  }
  if (event.what == What::kUp) {
    v.inbox.push_back(v.up.receive());
    take(i);
  }
  if (event.what == What::kDown) {
    const auto lateness = v.light.receive(v.down.receive(), now_ + v.clock);
    if (lateness && isMeasured() && *lateness > Duration{}) ++figures_.late_at_viewers;
  }
  if (event.what == What::kDrained && v.waits_for_drain && v.down.drainedAt() <= now_) {
    v.waits_for_drain = false;
    if (!v.is_running) v.session.onDrained(now_), schedule(i);
  }
  if (event.what == What::kDone) done(i);
}

// Messages wait for a step that runs to end, as in a server's inbox.
void Simulation::take(size_t i) {
  Viewer& v = *viewers_[i];
  if (v.is_running) return;
  for (; !v.inbox.empty(); v.inbox.pop_front()) CHECK_TRUE(v.session.receive(v.inbox.front(), now_).ok());
  schedule(i);
}

void Simulation::schedule(size_t i) {
  Viewer& v = *viewers_[i];
  if (v.is_queued) (void)queue_.cancel(v.ticket);
  v.is_queued = false;
  const auto due = v.session.due();
  if (!due) return;
  server::Due job{due->release, due->deadline, due->is_costly, due->work, due->earliest};
  if (options_.policy == LoadPolicy::kFair) job.deadline = job.deadline + v.debt.wait(share());
  v.ticket = queue_.add(job, [this, i](size_t) { step(i); });
  v.is_queued = true;
}

void Simulation::startJobs() {
  while (free_workers_ > 0) {
    auto entry = queue_.take(now_);
    if (!entry) break;
    entry->job(0);
  }
  if (free_workers_ == 0) return;
  const auto next = queue_.nextRelease();
  if (!next || (wake_ && *wake_ <= *next)) return;
  wake_ = std::max(*next, now_ + Duration{1});
  at(*wake_, What::kWake, 0);
}

void Simulation::step(size_t i) {
  Viewer& v = *viewers_[i];
  v.is_queued = false;
  v.is_running = true;
  --free_workers_;
  const auto due = v.session.due();
  v.deadline = due ? due->deadline : now_;
  v.has_deadline = due && due->deadline > due->release;
  const server::SessionStatistics before = v.session.statistics();
  const auto start = v.ticket.due.release > now_ ? Session::Start::kEarly : Session::Start::kWhenDue;
  v.session.step(now_, scratch_, v.out, start);
  uint64_t bytes = 0;
  for (const Bytes& message : v.out) bytes += message.size();
  const StepWork work = StepWork::between(before, v.session.statistics(), bytes);
  v.is_keyframe = work.keyframes > 0;
  v.work = options_.prices.of(work);
  if (isMeasured()) {
    figures_.skipped += v.session.statistics().skipped_keyframes - before.skipped_keyframes;
    figures_.ahead_mean_ms += v.is_keyframe && v.has_deadline ? (v.deadline - now_).toMilliseconds() : 0;
    work_ = {work_.keyframes + work.keyframes, work_.tested + work.tested, work_.changed + work.changed,
             work_.measured + work.measured, work_.bytes + work.bytes};
  }
  use(now_, now_ + v.work);
  at(now_ + v.work, What::kDone, i);
}

void Simulation::done(size_t i) {
  Viewer& v = *viewers_[i];
  ++free_workers_;
  v.is_running = false;
  v.session.noteComputeTime(v.work);
  v.debt.charge(v.work, now_, share());
  if (v.is_keyframe && isMeasured()) count(v);
  for (Bytes& message : v.out) {
    v.down.send(std::move(message), now_);
    at(*v.down.newestArrival(), What::kDown, i);
    v.waits_for_drain = true;
  }
  if (!v.out.empty()) at(std::max(now_, v.down.drainedAt()), What::kDrained, i);
  v.out.clear();
  take(i);
}

void Simulation::count(Viewer& v) {
  v.in_time += now_ <= v.deadline || !v.has_deadline;
  figures_.at_once += !v.has_deadline;
  if (!v.has_deadline) return;
  ++figures_.keyframes;
  figures_.missed += now_ > v.deadline;
  lateness_ms_.push_back((now_ - v.deadline).toMilliseconds());
  work_ms_.push_back(v.work.toMilliseconds());
}

void Simulation::use(Time from, Time to) {
  from = std::max(from, begin_), to = std::min(to, end_);
  while (from < to) {
    const int64_t bin = (from - begin_).us / kUtilisationBin.us;
    const Time end = std::min(to, begin_ + kUtilisationBin * (bin + 1));
    busy_us_[static_cast<size_t>(bin)] += (end - from).us;
    from = end;
  }
}

LoadRun Simulation::result() const {
  LoadRun run{.options = options_, .figures = figures_, .used = {}, .lateness_ms = lateness_ms_};
  LoadFigures& f = run.figures;
  std::sort(run.lateness_ms.begin(), run.lateness_ms.end());
  const double n = static_cast<double>(std::max<uint64_t>(f.keyframes, 1));
  f.missed_share = static_cast<double>(f.missed) / n;
  f.ahead_mean_ms /= n;
  f.lateness_p50_ms = quantile(lateness_ms_, 0.5), f.lateness_p99_ms = quantile(lateness_ms_, 0.99);
  f.lateness_max_ms = quantile(lateness_ms_, 1);
  f.work_p99_ms = quantile(work_ms_, 0.99);
  for (const double ms : work_ms_) f.work_mean_ms += ms / n;
  const double bin_us = static_cast<double>(kUtilisationBin.us) * static_cast<double>(options_.workers);
  for (const int64_t us : busy_us_) run.used.push_back(static_cast<double>(us) / bin_us);
  run.used.pop_back();  // it is beyond the end
  for (const double used : run.used) f.utilisation += used / static_cast<double>(run.used.size());
  f.utilisation_peak = quantile(run.used, 0.99);
  double sum = 0, squares = 0;
  for (const auto& v : viewers_) {
    const double asked = options_.seconds / v->light.request().keyframe_interval.toSeconds();
    const double got = static_cast<double>(v->in_time) / asked;
    sum += got, squares += got * got;
  }
  f.jain = squares > 0 ? sum * sum / (static_cast<double>(viewers_.size()) * squares) : 0;
  const ComputePrices& p = options_.prices;
  f.shares = {p.keyframe * static_cast<double>(work_.keyframes), p.tested * static_cast<double>(work_.tested),
              p.changed * static_cast<double>(work_.changed), p.measured * static_cast<double>(work_.measured),
              p.byte * static_cast<double>(work_.bytes)};
  double all = 0;
  for (const double share : f.shares) all += share;
  for (double& share : f.shares) share /= std::max(all, 1.0);
  return run;
}

template <class E, size_t N>
Result<E> named(const std::string& name, const char* what, const std::array<const char*, N>& names) {
  std::string all;
  for (size_t i = 0; i < N; ++i) {
    if (name == names[i]) return static_cast<E>(i);
    all += (i == 0 ? "" : ", ") + std::string(names[i]);
  }
  return Error{ErrorCode::kInvalidArgument,
               std::string("there is no ") + what + " '" + name + "'; choose one of " + all};
}

constexpr std::array<const char*, 4> kPolicies{"fifo", "edf", "least-laxity", "fair"};
constexpr std::array<const char*, 3> kPhases{"synchronised", "random", "staggered"};
constexpr std::array<const char*, 2> kMixes{"mixed", "survey"};

}  // namespace

const char* name(LoadPolicy policy) { return kPolicies[static_cast<size_t>(policy)]; }
const char* name(Phases phases) { return kPhases[static_cast<size_t>(phases)]; }
const char* name(LoadStart start) { return start == LoadStart::kLate ? "late" : "early"; }
Result<LoadPolicy> policyNamed(const std::string& name) { return named<LoadPolicy>(name, "policy", kPolicies); }
Result<Phases> phasesNamed(const std::string& name) { return named<Phases>(name, "phases", kPhases); }
Result<Mix> mixNamed(const std::string& name) { return named<Mix>(name, "mix of viewers", kMixes); }

LoadRun runLoad(const std::shared_ptr<const server::World>& world, const LoadOptions& options) {
  Simulation simulation(world, options);
  simulation.run();
  return simulation.result();
}

}  // namespace foreland::bench
