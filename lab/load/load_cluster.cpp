// The part of LoadSimulation that is about several servers: viewers who connect, are moved, migrated or lost.
#include <algorithm>
#include <utility>

#include "lab/load/load_simulation.h"
#include "server/session/migration.h"

namespace foreland::lab {

namespace {

// A viewer who lost its server waits up to so long, as with `foreland fly`, and the longest time a server takes to hand
// its viewers over.
constexpr int64_t kFirstRetry_us = 200'000;
constexpr Duration kLongestDrain = Duration::seconds(10);
constexpr Duration kNoServer = Duration::milliseconds(10);  // until a balancer looks for one again
constexpr size_t kCloseBytes = 4;                           // of WebSocket, with its reason
constexpr double kNewest = 0.125;                           // weight of the newest look at a viewer's load
constexpr Duration kDwells =
    Duration::milliseconds(5000);  // at least, before a viewer is moved, for its first keyframes cost more

Duration roundTrip(const sim::LinkPair& links) { return links.up.latency + links.down.latency; }

}  // namespace

void LoadSimulation::addClusterEvents() {
  for (size_t s = 0; s < servers_.size(); ++s) servers_[s].is_up = servers_[s].is_open = options_.cluster.isThere(s);
  for (size_t e = 0; e < options_.cluster.events.size(); ++e)
    at(begin_ + Duration::seconds(options_.cluster.events[e].at_s), What::kServer, e);
  in_time_.resize(static_cast<size_t>((end_ - begin_).us / kClusterBin.us) + 1);
  at(Time{} + kBalanceEvery, What::kBalance, 0);
}

void LoadSimulation::connect(size_t i) {
  Viewer& v = *viewers_[i];
  if (isCluster()) {
    const auto server = serverFor(i);
    if (!server) return wait(i);
    v.server = *server;
    ++turn_;
  }
  session_options_.occlusion_rank = server::OcclusionControl::rankOf(i);
  session_options_.foresee = v.is_jumper ? nullptr : foresee_;
  v.session = std::make_unique<server::Session>(world_, session_options_);
  servers_[v.server].load->addViewer();
  v.session->setProcessors(server::Processors::kFree, servers_[v.server].load->occlusionShare());
  if (v.connection > 0) {
    v.up = sim::Link(v.links.up, v.seeds.next());
    v.down = sim::Link(v.links.down, v.seeds.next());
  }
  v.connected_at = v.charged_at = now_;
  v.cost = 0;
  v.move = {};
  Bytes request = v.light.connect();
  v.move.up = request.size();
  send(i, std::move(request), now_);
  if (auto path = v.light.announce(now_ + v.clock, end_ + v.clock)) send(i, std::move(*path), now_);
}

// Where those who resume are queued, they wait their turn; others find a server if there is one.
std::optional<size_t> LoadSimulation::serverFor(size_t i) {
  Viewer& v = *viewers_[i];
  const auto chosen = std::exchange(v.goes_to, std::nullopt);
  if (chosen && servers_[*chosen].is_open) return chosen;
  std::vector<ServerLoad> servers = serverLoads();
  if (v.connection == 0)
    for (ServerLoad& server : servers) server.is_pausing = false;
  else if (balancer_->queuesResumed())
    return std::nullopt;
  return balancer_->place(servers, {now_, turn_, v.connection > 0});
}

void LoadSimulation::wait(size_t i) {
  waiting_.push_back(i);
  if (waiting_.size() == 1) at(now_ + kNoServer, What::kAdmit, 0);
}

// Those who hold least first, for then the fewest wait for long.
void LoadSimulation::admit() {
  const auto holdsLess = [&](size_t a, size_t b) { return viewers_[a]->resume_work < viewers_[b]->resume_work; };
  // By insertion, which is stable; libstdc++'s stable_sort uses what clang warns of.
  for (auto it = waiting_.begin(); it != waiting_.end(); ++it)
    std::rotate(std::upper_bound(waiting_.begin(), it, *it, holdsLess), it, it + 1);
  while (!waiting_.empty()) {
    Viewer& v = *viewers_[waiting_.front()];
    v.goes_to = balancer_->place(serverLoads(), {now_, turn_, v.connection > 0});
    if (!v.goes_to) break;
    pace(*v.goes_to, v);
    connect(waiting_.front());
    waiting_.erase(waiting_.begin());
  }
  if (!waiting_.empty()) at(now_ + kNoServer, What::kAdmit, 0);
}

void LoadSimulation::pace(size_t server, const Viewer& v) {
  const double spare = static_cast<double>(options_.workers) * (1 - serverLoads()[server].used);
  servers_[server].resumes.take(v.resume_work, spare, now_);
}

// Its first keyframe's region is not known to be small, and so is measured: two or three refinements from scratch.
Duration LoadSimulation::resumeWork(const Viewer& v) const {
  constexpr uint64_t kMeasured = 3;
  const server::SessionStatistics& s = v.session->statistics();
  return options_.prices.of(
             {.measured = kMeasured * s.section_nodes, .resumed = s.section_nodes + s.remembered_nodes}) +
         v.session->computeTime();
}

// The step that runs is the last one.
void LoadSimulation::leave(size_t i, MoveCause cause) {
  Viewer& v = *viewers_[i];
  if (!v.session || v.leaving) return;
  v.leaving = cause;
  if (!v.is_running) close(i);
}

// Everything that was computed is still sent; the viewer then connects again at once.
void LoadSimulation::close(size_t i) {
  Viewer& v = *viewers_[i];
  v.moving = v.closing = std::exchange(v.leaving, std::nullopt);
  if (std::exchange(v.is_queued, false)) servers_[v.server].queues.cancel(v.ticket);
  v.resume_work = resumeWork(v);
  v.session.reset();
  v.inbox.clear();
  v.waits_for_drain = false;
  v.down.send(Bytes(kCloseBytes), now_);
  at(*v.down.newestArrival(), What::kDown, i, v.connection);
}

// Nothing that was under way arrives, and the viewer hears of it as soon as its link allows.
void LoadSimulation::lose(size_t i) {
  Viewer& v = *viewers_[i];
  v.moving = MoveCause::kLost;
  v.resume_work = resumeWork(v);
  v.leaving.reset();
  v.session.reset();
  v.inbox.clear();
  v.out.clear();
  v.is_queued = v.is_running = v.waits_for_drain = false;
  const Duration wait{static_cast<int64_t>(balancing_.below(kFirstRetry_us))};
  connectLater(i, v.links.down.latency + wait);
}

// A round trip each for the connection and for WebSocket's greeting.
void LoadSimulation::connectLater(size_t i, Duration wait) {
  Viewer& v = *viewers_[i];
  v.closing.reset();
  ++v.connection;
  at(now_ + wait + roundTrip(v.links) * 2, What::kConnect, i);
}

void LoadSimulation::arrived(Viewer& v, const LightViewer::Received& keyframe, size_t bytes) {
  if (v.moving && v.session && v.last_keyframe_at && isMeasured()) {
    v.move.cause = *v.moving;
    v.move.is_resumed = keyframe.is_resumed;
    v.move.at_s = (now_ - begin_).toSeconds();
    v.move.gap_ms = (now_ - *v.last_keyframe_at).toMilliseconds();
    v.move.down += bytes;
    moves_.push_back(v.move);
  }
  if (v.session) v.moving.reset();
  v.last_keyframe_at = now_;
}

void LoadSimulation::change(const ServerEvent& event) {
  Server& server = servers_[event.server];
  if (event.what == ServerEvent::What::kDrain) return drain(event.server);
  if (event.what == ServerEvent::What::kJoin) {
    if (!server.is_up) server.is_free.assign(options_.workers, true), server.costly_running = 0;
    server.is_up = server.is_open = true;
    server.resumes = {};
    return;
  }
  server.is_up = server.is_open = false;
  server.resumes = {};
  for (size_t i = 0; i < viewers_.size(); ++i) {
    Viewer& v = *viewers_[i];
    if (!v.session || v.server != event.server) continue;
    if (v.is_queued) server.queues.cancel(v.ticket);
    lose(i);
  }
}

void LoadSimulation::drain(size_t s) {
  servers_[s].is_open = false;
  std::vector<size_t> on_it;
  for (size_t i = 0; i < viewers_.size(); ++i)
    if (viewers_[i]->session && viewers_[i]->server == s) on_it.push_back(i);
  const server::MigrationTurns turns(on_it.size(), now_, kLongestDrain);
  for (size_t turn = 0; turn < on_it.size(); ++turn)
    at(turns.timeOf(turn), What::kMigrate, on_it[turn], viewers_[on_it[turn]]->connection);
}

std::vector<ServerLoad> LoadSimulation::serverLoads() const {
  std::vector<ServerLoad> loads;
  for (const Server& server : servers_) loads.push_back({server.is_open, 0, server.resumes.isPausing(now_)});
  for (const auto& v : viewers_) {
    const auto server = v->session ? std::optional(v->server) : v->goes_to;
    if (server) loads[*server].used += expectedLoad(*v) / static_cast<double>(options_.workers);
  }
  return loads;
}

ViewerLoad LoadSimulation::loadOf(const Viewer& v) const {
  ViewerLoad load{.server = v.server, .used = expectedLoad(v) / static_cast<double>(options_.workers)};
  load.is_movable = v.session && !v.leaving && !v.moving && now_ - v.connected_at >= kDwells;
  if (v.session) load.resume_s = resumeWork(v).toSeconds();
  return load;
}

// What a viewer's first keyframes cost says little of the ones to come.
void LoadSimulation::observeLoads() {
  constexpr uint64_t kFirstOnes = 3;
  double sum = 0;
  size_t known = 0;
  for (const auto& viewer : viewers_) {
    Viewer& v = *viewer;
    const double used = std::exchange(v.used_s, 0.0) / kBalanceEvery.toSeconds();
    if (v.session && v.session->statistics().keyframes > kFirstOnes) {
      v.load = v.is_known ? v.load + kNewest * (used - v.load) : used;
      v.is_known = true;
    }
    if (v.is_known) sum += v.load, ++known;
  }
  mean_load_ = known > 0 ? sum / static_cast<double>(known) : 0.01;
}

void LoadSimulation::balance() {
  at(now_ + kBalanceEvery, What::kBalance, 0);
  observeLoads();
  const std::vector<ServerLoad> servers = serverLoads();
  look(servers);
  std::vector<ViewerLoad> viewers;
  for (const auto& v : viewers_) viewers.push_back(loadOf(*v));
  const auto move = balancer_->move(servers, viewers, now_);
  if (!move) return;
  viewers_[move->viewer]->resume_work = Duration::seconds(viewers[move->viewer].resume_s);
  viewers_[move->viewer]->goes_to = move->to;
  pace(move->to, *viewers_[move->viewer]);
  leave(move->viewer, MoveCause::kBalanced);
}

// What a report shows of the servers.
void LoadSimulation::look(std::span<const ServerLoad> expected) {
  if (!isMeasured()) return;
  double most = 0, sum = 0;
  size_t open = 0;
  for (const ServerLoad& server : expected)
    if (server.is_open) most = std::max(most, server.used), sum += server.used, ++open;
  if (open > 0) imbalance_ += most - sum / static_cast<double>(open), ++looks_;
  if (now_ == begin_ || (now_ - begin_).us % kClusterBin.us != 0) return;
  const auto to = static_cast<std::ptrdiff_t>((now_ - begin_).us / kUtilisationBin.us),
             from = to - static_cast<std::ptrdiff_t>(kClusterBin.us / kUtilisationBin.us);
  for (size_t s = 0; s < servers_.size(); ++s) {
    ServerLook look{.time_s = (now_ - begin_).toSeconds(), .server = s};
    for (auto bin = from; bin < to; ++bin) look.used += static_cast<double>(servers_[s].busy_us[bin]);
    look.used /= static_cast<double>(kClusterBin.us) * static_cast<double>(options_.workers);
    for (const auto& v : viewers_) look.viewers += v->session && v->server == s;
    looks_taken_.push_back(look);
  }
}

void LoadSimulation::addClusterResult(LoadRun& run) const {
  ClusterFigures f;
  for (const auto& v : viewers_) {
    const auto asked =
        static_cast<uint64_t>(options_.seconds / v->light.request().keyframe_interval.toSeconds() + 1e-9);
    f.asked += asked;
    f.not_in_time += asked - std::min(asked, v->in_time);
  }
  f.not_in_time_share = static_cast<double>(f.not_in_time) / static_cast<double>(std::max<uint64_t>(f.asked, 1));
  f.imbalance = looks_ > 0 ? imbalance_ / static_cast<double>(looks_) : 0;
  sumUp(moves_, f);
  run.cluster = ClusterRun{f, moves_, in_time_, looks_taken_};
  run.cluster->in_time.pop_back();  // it is beyond the end
}

}  // namespace foreland::lab
