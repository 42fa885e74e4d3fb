// What is done with a flight after landing, on a replay of its log: measuring it against the truth, and dumping frames.
// For `foreland fly` and `foreland replay`. Main thread.
#pragma once

#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "apps/options/foreign_files.h"
#include "base/result.h"
#include "client/fly/frame_dump.h"
#include "client/fly/player.h"
#include "oracle/flight_truth.h"
#include "oracle/scene_oracle.h"
#include "terrain/store/scene.h"

namespace CLI {
class App;
}

namespace foreland::apps {

struct AfterwardsOptions {
  std::filesystem::path truth;  // empty: nothing is measured
  uint32_t truth_every = oracle::FlightTruthOptions{}.frame_every;
  uint32_t truth_frames = oracle::FlightTruthOptions{}.max_frames;
  std::optional<uint32_t> truth_terms_every;
  std::vector<std::string> sources;  // of a globe; empty: it is measured against the scene alone
  ForeignFiles foreign;
  unsigned threads = 0;
  std::filesystem::path dump;  // empty: nothing is dumped
  uint32_t dump_every = 60;
};

// Adds --truth and what belongs to it, --dump and --dump-every, which write into `options`.
void addAfterwardsOptions(CLI::App& app, AfterwardsOptions& options);

class Afterwards {
 public:
  // Opens what the options name, so that mistakes are reported before the flight. To be called before threads are
  // started.
  static Result<Afterwards> prepare(const AfterwardsOptions& options);

  // Whether sections that leave out what is hidden can be judged: not in scenes that change in time.
  bool canJudgeSeen() const { return !truth_ || truth_->epochs().epochs().empty(); }
  // An Error if the truth is not the scene that the server shows. Nothing before its welcome.
  Status checkScene(const client::Viewer& viewer) const;
  // Measures on all threads, and tells the progress on standard error. A signal to stop (catchStopSignals) ends it:
  // what was measured until then is returned. `terms_every` counts without --truth-terms-every. nullopt without
  // --truth.
  std::optional<oracle::FlightTruth> measure(const client::FlightLog& log, uint32_t terms_every);
  // Dumps; the number of frames written, 0 without --dump.
  Result<uint64_t> dump(const client::FlightLog& log);

 private:
  void judgeOnlySeen();

  AfterwardsOptions options_;
  std::shared_ptr<const terrain::Scene> truth_;
  std::optional<oracle::SceneOracle> oracle_;  // of `truth_`
  std::optional<client::FrameDump> dump_;
};

}  // namespace foreland::apps
