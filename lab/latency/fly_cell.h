// One flight of `foreland bench latency`: the real session and viewer in virtual time, and some of its frames before
// the oracle. Deterministic: the same arguments give the same result on every run and thread.
#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "lab/latency/frame_terms.h"
#include "lab/latency/grid.h"
#include "lab/latency/judged_frames.h"
#include "sim/compute_cost.h"
#include "sim/link_models.h"

namespace foreland::lab {

// What all flights of an experiment share.
struct LatencyFlight {
  std::shared_ptr<const server::World> world;
  proto::Path path;     // from its start on; the first kRunIn of it is not measured
  double seconds = 20;  // measured
  JudgedFrames judged = {};
  proto::Lens lens = {};
  sim::ComputePrices prices = {};
  std::optional<sim::LinkPair> trace = {};  // of cells whose link is `trace`
  uint64_t seed = 1;
};

// Before the flight the camera stands at its first pose until the first section is there.
inline constexpr Duration kStanding = Duration::milliseconds(3000);
// After that the flight begins abruptly, and what it takes to recover from that is not measured.
inline constexpr Duration kRunIn = Duration::milliseconds(2000);

struct FlownKeyframe {
  double time_s = 0;  // of its arrival, since the flight began
  uint64_t bytes = 0;
  double lateness_ms = 0;
  double compute_ms = 0;
  sim::StepWork work;
};

// All frames that were shown while measured, whether judged or not.
struct ShownFrames {
  uint64_t count = 0, outside = 0, triangles = 0;
  double delay_ms = 0, delay_max_ms = 0;
  double tolerance_px = 0, tolerance_max_px = 0;  // of those that are not outside

  void add(const client::FrameView& view, Time now);
};

struct CellFlight {
  LatencyCell cell;
  Status status = {};                     // an Error of a program that takes part; then nothing else here is of any use
  std::vector<FrameTerms> frames;         // judged, by time
  std::vector<FlownKeyframe> keyframes;   // that arrived while measured
  uint64_t bytes_up = 0, bytes_down = 0;  // while measured, WebSocket's framing not counted
  ShownFrames shown;
};

CellFlight flyCell(const LatencyFlight& flight, const LatencyCell& cell, oracle::Oracle& oracle);

}  // namespace foreland::lab
