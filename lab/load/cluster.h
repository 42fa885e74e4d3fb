// Several servers of one load: how many, how viewers are shared among them, and what happens to them; and what the
// viewers' moves from one to another cost. Value types; any thread.
#pragma once

#include <string>
#include <vector>

#include "base/time.h"
#include "lab/load/balance.h"

namespace foreland::lab {

// fail: at once, with its connections and what it was computing; drain: it takes no more viewers and migrates those
// that it has, one after another (as server/net/drain.h); join: it takes viewers from then on.
struct ServerEvent {
  enum class What : uint8_t { kFail, kDrain, kJoin };
  What what = What::kFail;
  size_t server = 0;  // counted from 0; people count from 1
  double at_s = 0;    // in the measured time
};

struct ClusterOptions {
  size_t servers = 1;
  Balance balance = Balance::kRoundRobin;
  std::vector<ServerEvent> events{};  // a server whose first one is a join is not there before
  std::string balance_command{};      // a program in place of the balance; empty: none

  // Whether the server takes viewers at the beginning.
  bool isThere(size_t server) const;
};

// `SERVER@SECONDS`, as in 2@5. Errors name the text.
Result<ServerEvent> parseServerEvent(ServerEvent::What what, const std::string& text);
// Whether the events name servers that there are, in times that are measured, and leave one at the beginning.
Status checkCluster(const ClusterOptions& options, double seconds);

// Why a viewer connects again.
enum class MoveCause : uint8_t { kBalanced, kDrained, kLost };

struct ViewerMove {
  MoveCause cause = MoveCause::kBalanced;
  bool is_resumed = false;      // from what the viewer holds; otherwise from nothing
  double at_s = 0, gap_ms = 0;  // when it was there again; from its last keyframe until then
  uint64_t up = 0, down = 0;    // bytes of request and resume; of welcome and first keyframe
};

struct ClusterFigures {
  uint64_t asked = 0;        // keyframes, by the viewers' intervals
  uint64_t not_in_time = 0;  // of those: late, skipped, or not computed while their viewer had no server
  double not_in_time_share = 0;
  double imbalance = 0;  // use of the busiest server less the mean of those that are there, mean over time
  uint64_t moves = 0, migrated = 0, lost = 0;  // viewers who connected again, by cause
  uint64_t afresh = 0;                         // of them, those who could not resume
  double move_gap_p50_ms = 0, move_gap_max_ms = 0, lost_gap_p50_ms = 0, lost_gap_p99_ms = 0, lost_gap_max_ms = 0;
  double move_up_mean = 0, move_up_max = 0, move_down_mean = 0, move_down_max = 0;  // bytes, whatever the cause

  template <class Visit>
  void fields(const Visit& visit) const {
    visit("asked", asked);
    visit("not_in_time", not_in_time);
    visit("not_in_time_share", not_in_time_share);
    visit("imbalance", imbalance);
    visit("moves", moves);
    visit("handed_over", migrated);
    visit("lost", lost);
    visit("afresh", afresh);
    visit("move_gap_p50_ms", move_gap_p50_ms);
    visit("move_gap_max_ms", move_gap_max_ms);
    visit("lost_gap_p50_ms", lost_gap_p50_ms);
    visit("lost_gap_p99_ms", lost_gap_p99_ms);
    visit("lost_gap_max_ms", lost_gap_max_ms);
    visit("move_up_mean_bytes", move_up_mean);
    visit("move_up_max_bytes", move_up_max);
    visit("move_down_mean_bytes", move_down_mean);
    visit("move_down_max_bytes", move_down_max);
  }
};

// How a server was used in the kClusterBin before a time, and how many viewers it had then.
struct ServerLook {
  double time_s = 0;
  size_t server = 0;
  double used = 0;  // of its workers' time
  size_t viewers = 0;
};
inline constexpr Duration kClusterBin = Duration::milliseconds(500);

struct ClusterRun {
  ClusterFigures figures;
  std::vector<ViewerMove> moves;  // by the time of their end
  std::vector<uint64_t> in_time;  // keyframes, by kClusterBin
  std::vector<ServerLook> looks;
};

// Adds what the moves come to.
void sumUp(const std::vector<ViewerMove>& moves, ClusterFigures& figures);

}  // namespace foreland::lab
