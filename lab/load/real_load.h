// A load in real time: real servers in processes of their own, and the viewers of the same load in virtual time
// (load_cast.h), each with a thread and a connection of its own, on loopback through a proxy with their links
// (lab/proxy/proxy.h). Reads the clock. What this machine does beside shows in the times.
#pragma once

#include <filesystem>
#include <optional>
#include <vector>

#include "base/result.h"
#include "lab/load/load_run.h"
#include "terrain/store/scene.h"

namespace foreland::lab {

struct RealLoad {
  std::vector<ViewerTally> viewers;
  // By the server's own count, in the measured time.
  uint64_t server_keyframes = 0, server_missed = 0;
  double used = 0;  // processor time of the server's process, as a share of its workers' time
  // Of two servers, in place of these: the viewers who went on to the other one.
  std::vector<ViewerMove> moves{};
  std::optional<ClusterFigures> cluster{};
};

// Whether the options are those of `foreland serve`: fair, early starts, and one server, or two of which one ends. The
// Error names what is not.
Status checkReal(const LoadOptions& options);

// `serve`: the program. An Error if it does not start, refuses a viewer, or loses one.
Result<RealLoad> runRealLoad(const terrain::Scene& scene, const LoadOptions& options,
                             const std::filesystem::path& serve, const std::filesystem::path& scene_file);

// A figure of both worlds.
struct Agreement {
  const char* name;
  double virtual_time, real_time;
  double difference() const { return real_time - virtual_time; }
};
std::vector<Agreement> agreementOf(const LoadRun& virtual_time, const RealLoad& real_time);
// Of one viewer's bytes, as a share of those in virtual time.
double largestByteDifference(const LoadRun& virtual_time, const RealLoad& real_time);

}  // namespace foreland::lab
