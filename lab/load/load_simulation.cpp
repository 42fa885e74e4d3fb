#include "lab/load/load_simulation.h"

#include <algorithm>
#include <utility>

#include "base/check.h"
#include "lab/external/told_motion.h"

namespace foreland::lab {

using server::Session;

LoadSimulation::Server::Server(const LoadOptions& options, server::JobKey keyOf, size_t bins)
    : queues(options.queues, options.workers, keyOf),
      is_free(options.workers, true),
      load(std::make_unique<server::Load>(options.workers)),
      busy_us(bins) {}

LoadSimulation::Viewer::Viewer(const LoadViewer& viewer, LightViewer::Holds holds)
    : light(viewer.cast.request, viewer.cast.flight, holds),
      links(viewer.cast.links),
      up(links.up, viewer.link_seed),
      down(links.down, viewer.link_seed + 1),
      seeds(viewer.link_seed),
      clock(viewer.clock),
      is_jumper(viewer.cast.is_jumper) {}

LoadSimulation::LoadSimulation(std::shared_ptr<const server::World> world, const LoadOptions& options,
                               LoadPrograms& programs)
    : world_(std::move(world)),
      options_(options),
      begin_(Time::seconds(options.run_in_s)),
      end_(begin_ + Duration::seconds(options.seconds)),
      programs_(programs),
      order_(programs.order ? toldOrder(*programs.order) : makeOrder(options.policy)),
      balancer_(programs.balance ? toldBalancer(*programs.balance) : makeBalancer(options.cluster.balance, balancing_)),
      balancing_(options.seed + 1) {
  if (programs.predictor)
    foresee_ = [motion = std::make_shared<ToldMotion>(*programs.predictor)] { return motion->next(); };
  const size_t bins = static_cast<size_t>((end_ - begin_).us / kUtilisationBin.us) + 1;
  for (size_t s = 0; s < options.cluster.servers; ++s) servers_.emplace_back(options, order_->key(), bins);
  if (options.start == LoadStart::kEarly) session_options_.max_early = Duration::seconds(0.5e-3 * options.keyframe_ms);
  session_options_.occlusion = options.occlusion;
  session_options_.slack = Duration::seconds(1e-3 * options.slack_ms);
  due_us_.resize(static_cast<size_t>(1e3 * options.seconds / options.keyframe_ms + 1e-9));
  addViewers(world_);
  if (isCluster()) addClusterEvents();
}

void LoadSimulation::addViewers(const std::shared_ptr<const server::World>& world) {
  const LoadTours tours(world->hierarchy.scene());
  const auto holds = isCluster() ? LightViewer::Holds::kSections : LightViewer::Holds::kNothing;
  for (const LoadViewer& viewer : viewersOf(tours, options_, rolesOf(options_, balancing_))) {
    const size_t i = viewers_.size();
    viewers_.push_back(std::make_unique<Viewer>(viewer, holds));
    at(viewer.comes, What::kConnect, i);
    at(viewer.comes + kFirstPose, What::kPose, i);
  }
}

void LoadSimulation::run() {
  while (!events_.empty() && events_.top().at <= end_ && programs_.status().ok()) {
    const Event event = events_.top();
    events_.pop();
    now_ = std::max(now_, event.at);
    handle(event);
    for (size_t s = 0; s < servers_.size(); ++s) startJobs(s);
  }
}

void LoadSimulation::send(size_t i, Bytes message, Time t) {
  Viewer& v = *viewers_[i];
  v.up.send(std::move(message), t);
  at(*v.up.newestArrival(), What::kUp, i, v.connection);  // messages arrive in order, and each has an event
}

void LoadSimulation::handle(const Event& event) {
  const size_t i = event.index;
  if (event.what == What::kWake) servers_[i].wake.reset();
  if (event.what == What::kConnect) connect(i);
  if (event.what == What::kServer) change(options_.cluster.events[i]);
  if (event.what == What::kBalance) balance();
  if (event.what == What::kAdmit) admit();
  if (event.what == What::kPose) {
    Viewer& v = *viewers_[i];
    if (v.session && !v.closing)
      if (auto pose = v.light.pose(now_ + v.clock)) send(i, std::move(*pose), now_);
    at(now_ + LightViewer::kPoseInterval, What::kPose, i);
  }
  handleConnection(event);
}

// What belongs to a connection goes with it.
void LoadSimulation::handleConnection(const Event& event) {
  constexpr What kKinds[] = {What::kUp, What::kDown, What::kDrained, What::kDone, What::kMigrate};
  if (std::find(std::begin(kKinds), std::end(kKinds), event.what) == std::end(kKinds)) return;
  const size_t i = event.index;
  Viewer& v = *viewers_[i];
  if (event.connection != v.connection) return;
  if (event.what == What::kUp) {
    Bytes message = v.up.receive();
    if (v.session) v.inbox.push_back(std::move(message)), take(i);
  }
  if (event.what == What::kDown) receive(i);
  if (event.what == What::kDrained && v.waits_for_drain && v.session && v.down.drainedAt() <= now_) {
    v.waits_for_drain = false;
    if (!v.is_running) v.session->onDrained(now_), schedule(i);
  }
  if (event.what == What::kDone) done(i);
  if (event.what == What::kMigrate) leave(i, MoveCause::kDrained);
}

void LoadSimulation::receive(size_t i) {
  Viewer& v = *viewers_[i];
  const Bytes message = v.down.receive();
  if (v.closing && !v.down.nextArrival()) return connectLater(i, {});  // it was the end of the connection
  LightViewer::Received received = v.light.receive(message, now_ + v.clock);
  if (received.resume) {
    v.move.up += received.resume->size();
    if (!v.closing) send(i, std::move(*received.resume), now_);
  }
  const Duration interval = v.light.request().keyframe_interval;
  v.tally.add(received, message.size(), begin_ + v.clock + interval, end_ + v.clock - interval);
  if (!received.is_keyframe) v.move.down += message.size();
  if (!received.is_keyframe) return;
  if (isMeasured()) {
    figures_.late_at_viewers += received.lateness > Duration{} ? 1 : 0;
    figures_.latest_at_viewers_ms = std::max(figures_.latest_at_viewers_ms, received.lateness.toMilliseconds());
    figures_.largest_tau_px = std::max(figures_.largest_tau_px, received.tau_px);
    figures_.tau_times_mean += received.tau_px / v.light.request().tau_px;
    ++received_;
  }
  arrived(v, received, message.size());
}

// Messages wait for a step that runs to end, as in a server's inbox.
void LoadSimulation::take(size_t i) {
  Viewer& v = *viewers_[i];
  if (v.is_running) return;
  for (; !v.inbox.empty(); v.inbox.pop_front()) CHECK_TRUE(v.session->receive(v.inbox.front(), now_).ok());
  schedule(i);
}

void LoadSimulation::schedule(size_t i) {
  Viewer& v = *viewers_[i];
  WorkerQueues& queues = servers_[v.server].queues;
  if (v.is_queued) queues.cancel(v.ticket);
  v.is_queued = false;
  const auto due = v.session->due();
  if (!due) return;
  server::Due job{due->release, due->deadline, due->is_costly, due->work, due->earliest};
  order_->place(job, {i, v.deficit, share()}, now_);
  v.ticket = queues.add(i, job, [this, i](size_t worker) { step(i, worker); });
  v.is_queued = true;
}

// Every free worker looks into its own queue before one looks into another's. As Pool: of several workers one takes no
// costly jobs.
bool LoadSimulation::startJob(Server& server) {
  using Take = WorkerQueues::Take;
  const size_t most_costly = std::max<size_t>(1, options_.workers - 1);
  const Take which = server.costly_running < most_costly ? Take::kAny : Take::kCheap;
  for (const bool is_own : {true, false})
    for (size_t worker = 0; worker < options_.workers; ++worker) {
      if (!server.is_free[worker]) continue;
      auto entry = is_own ? server.queues.takeOwn(now_, worker, which) : server.queues.steal(now_, worker, which);
      if (!entry) continue;
      entry->job(worker);
      return true;
    }
  return false;
}

void LoadSimulation::startJobs(size_t s) {
  Server& server = servers_[s];
  if (!server.is_up) return;
  while (startJob(server)) {}
  if (std::ranges::find(server.is_free, true) == server.is_free.end()) return;
  const auto next = server.queues.nextRelease();
  if (!next || (server.wake && *server.wake <= *next)) return;
  server.wake = std::max(*next, now_ + Duration{1});
  at(*server.wake, What::kWake, s);
}

void LoadSimulation::step(size_t i, size_t worker) {
  Viewer& v = *viewers_[i];
  Server& server = servers_[v.server];
  v.is_queued = false;
  v.is_running = true;
  v.worker = worker;
  server.is_free[worker] = false;
  const auto due = v.session->due();
  v.deadline = due ? due->deadline : now_;
  v.has_deadline = due && due->deadline > due->release;
  v.is_costly = v.ticket.job.due.is_costly;
  server.costly_running += v.is_costly;
  const server::SessionStatistics before = v.session->statistics();
  const auto start = due && due->release > now_ ? Session::Start::kEarly : Session::Start::kWhenDue;
  v.session->step(now_, scratch_, v.out, start);
  uint64_t bytes = 0;
  for (const Bytes& message : v.out) bytes += message.size();
  const sim::StepWork work = sim::StepWork::between(before, *v.session, bytes);
  v.is_keyframe = work.keyframes > 0;
  v.work = slowed(options_.prices.of(work));
  if (v.is_keyframe && due) server.load->addWait(now_ - due->release);
  if (before.keyframes > 0) v.used_s += v.work.toSeconds();
  noteDue(due ? due->release : now_, v.work);
  if (isMeasured()) {
    figures_.skipped += v.session->statistics().skipped_keyframes - before.skipped_keyframes;
    figures_.ahead_mean_ms += v.is_keyframe && v.has_deadline ? (v.deadline - now_).toMilliseconds() : 0;
    work_ += work;
  }
  use(server, now_, now_ + v.work);
  at(now_ + v.work, What::kDone, i, v.connection);
}

void LoadSimulation::done(size_t i) {
  Viewer& v = *viewers_[i];
  Server& server = servers_[v.server];
  server.is_free[v.worker] = true;
  server.costly_running -= v.is_costly;
  v.is_running = false;
  v.session->noteComputeTime(v.work);
  charge(v, server);
  if (v.is_keyframe && isMeasured()) count(v);
  for (Bytes& message : v.out) {
    v.down.send(std::move(message), now_);
    at(*v.down.newestArrival(), What::kDown, i, v.connection);
    v.waits_for_drain = true;
  }
  if (!v.out.empty()) at(std::max(now_, v.down.drainedAt()), What::kDrained, i, v.connection);
  v.out.clear();
  if (v.leaving) return close(i);
  take(i);
}

void LoadSimulation::charge(Viewer& v, Server& server) {
  v.deficit.charge(v.work, now_, share());
  v.cost = server::Load::costAfter(v.cost, v.work, now_ - std::exchange(v.charged_at, now_));
  server.load->add(v.work, now_);
  const auto flying = static_cast<int64_t>(viewers_.size() / servers_.size());
  v.session->setProcessors(server.load->processorsFor(v.cost, flying), server.load->occlusionShare());
}

void LoadSimulation::count(Viewer& v) {
  const bool is_in_time = now_ <= v.deadline || !v.has_deadline;
  v.in_time += is_in_time;
  if (isCluster()) in_time_[static_cast<size_t>((now_ - begin_).us / kClusterBin.us)] += is_in_time;
  figures_.at_once += !v.has_deadline;
  if (!v.has_deadline) at_once_ms_.push_back((now_ - v.deadline).toMilliseconds());
  if (!v.has_deadline) return;
  ++figures_.keyframes;
  figures_.missed += now_ > v.deadline;
  lateness_ms_.push_back((now_ - v.deadline).toMilliseconds());
  work_ms_.push_back(v.work.toMilliseconds());
}

// What is begun while the neighbour is there takes longer; a step is short beside that time.
Duration LoadSimulation::slowed(Duration work) const {
  const bool is_beside = now_ >= begin_ && (now_ - begin_).us % kNeighbourEvery.us < kNeighbourFor.us;
  return is_beside ? Duration::seconds(work.toSeconds() / (1 - options_.neighbour)) : work;
}

void LoadSimulation::noteDue(Time due, Duration work) {
  if (due < begin_) return;
  const auto interval = static_cast<size_t>((due - begin_).toMilliseconds() / options_.keyframe_ms);
  if (interval < due_us_.size()) due_us_[interval] += work.us;
}

void LoadSimulation::use(Server& server, Time from, Time to) {
  from = std::max(from, begin_), to = std::min(to, end_);
  while (from < to) {
    const int64_t bin = (from - begin_).us / kUtilisationBin.us;
    const Time end = std::min(to, begin_ + kUtilisationBin * (bin + 1));
    server.busy_us[static_cast<size_t>(bin)] += (end - from).us;
    from = end;
  }
}

double LoadSimulation::share() const {
  return 0.85 * static_cast<double>(options_.workers * servers_.size()) / static_cast<double>(options_.viewers);
}

}  // namespace foreland::lab
