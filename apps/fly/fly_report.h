// The report that `foreland fly` prints. Pure; any thread.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "bench/oracle/flight_truth.h"
#include "bench/report.h"
#include "client/fly/player.h"

namespace foreland::apps {

struct FlySummary {
  proto::ViewRequest request;
  client::Blend blend = client::Blend::kKeyframe;
  client::FlightReport flight;
  std::optional<bench::FlightTruth> truth;
  uint64_t dumped_frames = 0;
  std::vector<std::string> notes;
  std::optional<std::string> error;  // why the flight ended early
};

std::string text(const FlySummary& summary, bench::ReportFormat format);
// What the keys of the report mean, for --help.
const char* reportHelp();

}  // namespace foreland::apps
