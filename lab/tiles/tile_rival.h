// `foreland bench tiles`: one flight, once with our own session and viewer and once pulling tiles as CesiumJS does,
// over the same link and before the same oracle. Deterministic.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "lab/cells.h"
#include "lab/tiles/tile_client.h"
#include "oracle/oracle.h"
#include "proto/space/path.h"
#include "server/session/world.h"
#include "sim/compute_cost.h"

namespace foreland::lab {

// Before the flight the camera stands until everything is there.
inline constexpr Duration kTilesStanding = Duration::milliseconds(5000);

struct RivalFlight {
  std::shared_ptr<const server::World> world;
  proto::Path path;  // begins at kTilesStanding
  double seconds = 10;
  double tau_px = 1;
  proto::Lens lens{};
  sim::LinkPair links{};
  sim::ComputePrices prices{};
  uint64_t seed = 1;
};

// What had come, and what was drawn, at a time after the connection.
struct RivalLook {
  double time_s = 0;
  uint64_t bytes = 0;
  size_t triangles = 0;
  bool is_settled = false;  // as `unsettled_share` counts
};
inline constexpr int64_t kLookEvery = 15;  // frames

struct RivalFigures {
  std::string way;                  // foreland, quantized-mesh, draco
  double asked_px = 0;              // tolerance; maximumScreenSpaceError
  uint64_t bytes = 0;               // down, the first view included
  uint64_t bytes_once = 0;          // of different tiles; of foreland the same as bytes
  uint64_t bytes_in_flight = 0;     // after the camera has begun to move
  uint64_t requests = 0;            // messages up: poses, or tiles
  uint64_t requests_in_flight = 0;  // of those
  double compute_ms = 0;            // of the server's processor, at its prices; tiles are files
  double compute_in_flight_ms = 0;  // of that
  double triangles = 0;             // mean
  double rms_px = 0, max_px = 0;    // against the truth, in flight, one frame each second
  double jump_max_px = 0;           // the largest motion of a vertex by level of detail in a frame
  double unsettled_longest_ms = 0;  // for which the tolerance did not hold, or tiles in view were missing
  double unsettled_share = 0;       // of all frames in flight
  std::vector<RivalLook> looks{};   // over time; no field of the table

  template <class Visit>
  void fields(const Visit& visit) const {
    visit("way", way);
    visit("asked_px", asked_px);
    visit("bytes", bytes);
    visit("bytes_once", bytes_once);
    visit("bytes_in_flight", bytes_in_flight);
    visit("requests", requests);
    visit("requests_in_flight", requests_in_flight);
    visit("compute_ms", compute_ms);
    visit("compute_in_flight_ms", compute_in_flight_ms);
    visit("triangles", triangles);
    visit("rms_px", rms_px);
    visit("max_px", max_px);
    visit("jump_max_px", jump_max_px);
    visit("unsettled_longest_ms", unsettled_longest_ms);
    visit("unsettled_share", unsettled_share);
  }
};

// The row of results.csv, and the rows of over_time.csv.
CellTables tablesOf(const RivalFigures& figures);
inline constexpr CellNames kTilesNames{"flight", "ways"};

// The path with a jump in the middle of what is flown, to where it would be a quarter of it later.
proto::Path withJump(const proto::Path& path, double seconds);

RivalFigures flyOurs(const RivalFlight& flight, oracle::Oracle& oracle);
Result<RivalFigures> flyTiles(const RivalFlight& flight, const TileOptions& options, TileTree& tree,
                              oracle::Oracle& oracle);
// The maximumScreenSpaceError at which tiles have this error, to a twentieth of it, between 0.1 and 100 px.
Result<double> errorForRms(const RivalFlight& flight, double rms_px, TileTree& tree, oracle::Oracle& oracle);

}  // namespace foreland::lab
