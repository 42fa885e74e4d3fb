// One run of `foreland bench load`: many real sessions and the server's own queue of jobs in virtual time, on workers
// whose time is priced (sim/compute_cost.h). What it leaves out of a server: sockets, and the few microseconds
// that taking a message costs. Deterministic.
#pragma once

#include <array>
#include <optional>
#include <string>
#include <vector>

#include "lab/load/cluster.h"
#include "lab/load/viewer_tally.h"
#include "lab/load/worker_queues.h"
#include "server/session/session.h"
#include "server/session/world.h"
#include "sim/compute_cost.h"
#include "sim/link_models.h"

namespace foreland::lab {

// fifo: in the order of release; edf: by deadline; least-laxity: by the time that is left; fair: by deadline, later for
// who has used more than an even share (server/sched/deficit.h).
enum class LoadPolicy : uint8_t { kFifo, kEdf, kLeastLaxity, kFair };
// When keyframes of different viewers are due: at once, at random, or evenly spread.
enum class Phases : uint8_t { kSynchronised, kRandom, kStaggered };
// Whether keyframes are begun as late as one alone could be, or early when several are due together (DeadlineQueue).
enum class LoadStart : uint8_t { kLate, kEarly };
// mixed: of 20 viewers 8 fly survey, 7 canyon and 2 spin, 1 jumps, 1 has a slow link, 1 is a hog. tours: of 20 viewers
// 8 fly survey, 7 canyon, 2 spin and 3 orbit, all with the same link, screen and tolerance. survey: all fly it.
enum class Mix : uint8_t { kMixed, kSurvey, kTours };

const char* name(LoadPolicy policy);
const char* name(Phases phases);
const char* name(LoadStart start);
const char* name(LoadQueues queues);
Result<LoadPolicy> policyNamed(const std::string& name);
Result<Phases> phasesNamed(const std::string& name);
Result<LoadQueues> queuesNamed(const std::string& name);
Result<Mix> mixNamed(const std::string& name);

struct LoadOptions {
  LoadPolicy policy = LoadPolicy::kEdf;
  std::string order_command{};  // a program in its place; empty: none
  Phases phases = Phases::kRandom;
  LoadStart start = LoadStart::kLate;
  double slack_ms = server::SessionOptions{}.slack.toMilliseconds();  // with kEarly
  LoadQueues queues = LoadQueues::kShared;
  Mix mix = Mix::kMixed;
  size_t viewers = 40, workers = 1;
  double seconds = 10;  // measured, after the run-in
  double run_in_s = 3;  // in which viewers come and get their first sections
  // Of the viewers so many come in the run-in's first second, the others one after another in step_s from the beginning
  // of what is measured on; 0: all come in the run-in.
  size_t before_step = 0;
  double step_s = 5;
  // Somebody else on the machine takes this share of the workers' time, kNeighbourFor of each kNeighbourEvery, from the
  // beginning of what is measured on; 0: nobody.
  double neighbour = 0;
  double crowd_jump_s = 0;  // all viewers jump each time so much has gone by, within one keyframe interval; 0: never
  double tau_px = 2, keyframe_ms = 200;
  proto::Predictor predictor = proto::Predictor::kConstantVelocity;  // of those who do not jump
  std::string predictor_command{};                                   // a program in its place; empty: none
  sim::LinkPair links = sim::fixedLink(Duration::milliseconds(50));  // of all, but that one of 20 is slow
  std::string link_command{};                                        // a program in their place; empty: none
  // Unless it is off viewers ask for it; the world must have what it needs.
  server::Occlusion occlusion = server::Occlusion::kOff;
  sim::ComputePrices prices{};
  uint64_t seed = 1;
  ClusterOptions cluster{};
};
// From when a viewer asks until it sends its first pose.
inline constexpr Duration kFirstPose = Duration::milliseconds(1);
inline constexpr Duration kUtilisationBin = Duration::milliseconds(20);
inline constexpr Duration kNeighbourEvery = Duration::milliseconds(2000), kNeighbourFor = Duration::milliseconds(500);

struct LoadFigures {
  uint64_t keyframes = 0, missed = 0, skipped = 0, late_at_viewers = 0;
  double latest_at_viewers_ms = 0;  // after the time from which it was to be shown
  double largest_tau_px = 0;        // that a keyframe stated
  double tau_times_mean = 0;        // the tolerance that keyframes stated, over the one that was asked for
  uint64_t at_once = 0;       // keyframes after a jump, which have no deadline and are in none of the other figures
  double at_once_p99_ms = 0;  // from when those were due to their end
  double missed_share = 0;
  double lateness_p50_ms = 0, lateness_p99_ms = 0, lateness_max_ms = 0;  // of the end, after the deadline
  double utilisation = 0, utilisation_peak = 0;  // the peak: in the busiest hundredth of the bins
  // Of the work that falls due in each keyframe interval: the most over the mean, and the share of the intervals in
  // which it is more than all workers have time for. So Eickhoff et al. look at a game's ticks ("Meterstick:
  // Benchmarking Performance Variability in Cloud and Self-hosted Minecraft-like Games", ICPE 2023).
  double peak_over_mean = 0, over_budget_share = 0;
  double jain = 0;                           // fairness of keyframes in time over those asked for
  double work_mean_ms = 0, work_p99_ms = 0;  // of a keyframe
  double ahead_mean_ms = 0;                  // how much before its deadline a keyframe was begun
  // Of the priced time: keyframe, tested, swept, changed, measured, bytes, resumed, hidden.
  std::array<double, 8> shares{};

  template <class Visit>
  void fields(const Visit& visit) const {
    visit("keyframes", keyframes);
    visit("missed", missed);
    visit("missed_share", missed_share);
    visit("at_once", at_once);
    visit("at_once_p99_ms", at_once_p99_ms);
    visit("skipped", skipped);
    visit("late_at_viewers", late_at_viewers);
    visit("latest_at_viewers_ms", latest_at_viewers_ms);
    visit("largest_tau_px", largest_tau_px);
    visit("tau_times_mean", tau_times_mean);
    visit("lateness_p50_ms", lateness_p50_ms);
    visit("lateness_p99_ms", lateness_p99_ms);
    visit("lateness_max_ms", lateness_max_ms);
    visit("utilisation", utilisation);
    visit("utilisation_peak", utilisation_peak);
    visit("peak_over_mean", peak_over_mean);
    visit("over_budget_share", over_budget_share);
    visit("jain", jain);
    visit("work_mean_ms", work_mean_ms);
    visit("work_p99_ms", work_p99_ms);
    visit("ahead_mean_ms", ahead_mean_ms);
    const char* const kShares[] = {"share_keyframe", "share_tested", "share_swept",   "share_changed",
                                   "share_measured", "share_bytes",  "share_resumed", "share_hidden"};
    for (size_t i = 0; i < shares.size(); ++i) visit(kShares[i], shares[i]);
  }
};

struct LoadRun {
  LoadOptions options;
  Status status{};  // an Error of a program that takes part; then nothing else here is of any use
  LoadFigures figures;
  std::vector<ViewerTally> viewers;
  std::vector<double> used;           // share of the workers' time, bin by bin
  std::vector<double> lateness_ms;    // of all keyframes, ascending
  std::optional<ClusterRun> cluster;  // of several servers
};

LoadRun runLoad(const std::shared_ptr<const server::World>& world, const LoadOptions& options);

}  // namespace foreland::lab
