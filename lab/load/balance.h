// On which of several servers a viewer is served. A balancer knows of each server whether it takes viewers, and of each
// viewer how much of a worker it used lately and how long a server will take to read what it holds; from that it places
// viewers who connect and, with `migrate`, moves some while they fly. Pure functions; any thread.
#pragma once

#include <algorithm>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "base/result.h"
#include "base/rng.h"
#include "base/time.h"

namespace foreland::lab {

// random; round-robin: one after another; least-loaded: the one whose viewers use least; two-choices: the less loaded
// of two at random (Mitzenmacher, IEEE TPDS 2001); migrate: as least-loaded, but viewers who resume wait until a server
// has time for them, those who hold least first (ResumePace), and the costliest viewers move from the busiest server to
// the least busy one.
enum class Balance : uint8_t { kRandom, kRoundRobin, kLeastLoaded, kTwoChoices, kMigrate };
const char* name(Balance balance);
// The Error lists the names.
Result<Balance> balanceNamed(const std::string& name);
std::vector<std::string> balanceNames();

// What a balancer knows of a server.
struct ServerLoad {
  bool is_open = true;      // takes viewers
  double used = 0;          // of its workers' time, expected: 1 is all of it
  bool is_pausing = false;  // takes nobody who resumes just now; only `migrate` cares
};

// The server for a viewer who connects; `turn` counts those who have come. Nothing if no server takes viewers. With
// `migrate` servers that pause are left out, too.
std::optional<size_t> placeViewer(Balance balance, std::span<const ServerLoad> servers, size_t turn, Rng& chance);

struct ViewerLoad {
  size_t server = 0;
  double used = 0;  // of its server's workers' time
  bool is_movable = true;
  double resume_s = 0;  // that a worker will take to read what it holds
};
struct Move {
  size_t viewer, to;
};
// The costliest viewer of the busiest server who uses no more than half the difference to the least used one, so that
// the move evens them out, and whose resuming takes at most `kLongestResume_s`, for while a worker reads what a viewer
// holds its other viewers wait. Nothing if the busiest server uses less than `kBusy`, where moving gains nothing, or if
// the difference is under `kUneven`, or if the other one pauses.
std::optional<Move> moveToMake(std::span<const ServerLoad> servers, std::span<const ViewerLoad> viewers);
inline constexpr double kBusy = 0.7, kUneven = 0.15, kLongestResume_s = 0.06;

// A viewer who is to be placed: at which time, as which of those who have come, and whether it resumes from what it
// holds.
struct Arrival {
  Time now;
  size_t turn = 0;
  bool is_resuming = false;
};

// How viewers are shared among servers in one run; `Balance`'s kinds are one implementation, a program of the user's is
// another (load_programs.h). One owner, a run's.
class Balancer {
 public:
  virtual ~Balancer() = default;
  // As placeViewer's.
  virtual std::optional<size_t> place(std::span<const ServerLoad> servers, const Arrival& arrival) = 0;
  // Whether viewers who resume wait in a queue, those who hold least first, and are placed as servers have time for
  // them; otherwise each is placed when it comes, whatever servers pause.
  virtual bool queuesResumed() const = 0;
  // As moveToMake's; asked each kBalanceEvery.
  virtual std::optional<Move> move(std::span<const ServerLoad> servers, std::span<const ViewerLoad> viewers,
                                   Time now) = 0;
};
// `chance` outlives it.
std::unique_ptr<Balancer> makeBalancer(Balance balance, Rng& chance);

// How fast a server takes viewers who resume: their work fills half of what the others leave of its workers' time, so
// that those are served meanwhile. Plain data; one owner.
class ResumePace {
 public:
  bool isPausing(Time now) const { return now < until_; }
  // A viewer comes whose resuming takes `work`, to a server whose workers have `spare` of a worker's time left.
  void take(Duration work, double spare, Time now) {
    constexpr double kUsed = 0.5, kMin = 0.05;
    until_ = now + Duration::seconds(work.toSeconds() / std::max(kMin, kUsed * spare));
  }

 private:
  Time until_;
};

}  // namespace foreland::lab
