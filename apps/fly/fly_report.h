// The report of `foreland fly` and `foreland replay`. Any thread.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "apps/fly/afterwards.h"
#include "apps/report/report.h"
#include "client/fly/flight_digest.h"
#include "client/fly/player.h"
#include "oracle/flight_truth.h"

namespace foreland::apps {

// Of a replay: what it showed, and whether that is what the recording says the flight showed.
struct ReplayedDigest {
  client::FlightDigest::Value shown;
  std::optional<client::FlightDigest::Value> recorded;  // absent if the recording ends early
};

struct FlySummary {
  std::string course;             // what was flown, for people
  std::optional<double> asked_s;  // absent: all of a track
  bool is_steered = false;        // by a person
  proto::ViewRequest request;     // its tolerance is that of the picture
  double exaggeration = 1;        // of heights in the picture
  client::Blend blend = client::Blend::kKeyframe;
  client::FlightReport flight;
  std::optional<oracle::FlightTruth> truth;
  uint64_t dumped_frames = 0;
  std::vector<std::string> notes;
  std::optional<std::string> error;  // why the flight ended early
  std::optional<ReplayedDigest> replayed;
};

// Of a player that has landed, or whose flight ended early.
FlySummary summaryOf(const client::Player& player);
// Measures and dumps, if asked to, and takes the results in. Terms of the error are for programs, unless asked for.
Status addAfterwards(Afterwards& afterwards, const client::FlightLog& log, ReportFormat format, FlySummary& summary);

// Of all keys, for programs.
nlohmann::ordered_json reportOf(const FlySummary& summary);
// Prints the report on standard output, or what it says to people.
void print(const FlySummary& summary, ReportFormat format);
// What the keys of the report mean, for --help.
const char* reportHelp();

}  // namespace foreland::apps
