// What keyframes cost a client: decoding, the mesh by change beside the mesh made anew, and what an upload of the
// changes takes, keyframe by keyframe along a recorded flight.
#pragma once

#include <vector>

#include "lab/wire/flight.h"

namespace foreland::lab {

// Of one keyframe; times are medians of passes.
struct KeyframeCosts {
  double decode_s = 0, mesh_s = 0, full_mesh_s = 0;
  size_t triangles = 0, changes = 0, upload_bytes = 0, uploads = 0, whole_bytes = 0;
};

// All but `keyframes` and the memory are of the keyframes after the first.
struct ClientCosts {
  uint64_t keyframes = 0;
  double triangles = 0, changes = 0;  // means: of the mesh, and nodes added and removed by a keyframe
  double mesh_ms_p50 = 0, mesh_ms_p99 = 0, mesh_us_per_change = 0;
  double full_mesh_ms = 0;                                         // made anew: the median, in the same run
  double mesh_ratio = 0;                                           // full_mesh_ms over mesh_ms_p50
  double upload_bytes_p50 = 0, upload_share = 0, uploads_p50 = 0;  // share: the sum of all over that of whole meshes
  double decode_ms_p50 = 0;
  double mesh_memory_bytes = 0;  // at the flight's end: the drawn arrays and what patches are made from

  template <class Visit>
  void fields(const Visit& visit) const {
    visit("keyframes", keyframes);
    visit("triangles", triangles);
    visit("changes", changes);
    visit("upload_bytes_p50", upload_bytes_p50);
    visit("upload_share", upload_share);
    visit("uploads_p50", uploads_p50);
    times(visit);
  }
  // What differs from machine to machine.
  template <class Visit>
  void times(const Visit& visit) const {
    visit("mesh_ms_p50", mesh_ms_p50);
    visit("mesh_ms_p99", mesh_ms_p99);
    visit("mesh_us_per_change", mesh_us_per_change);
    visit("full_mesh_ms", full_mesh_ms);
    visit("mesh_ratio", mesh_ratio);
    visit("decode_ms_p50", decode_ms_p50);
    visit("mesh_memory_bytes", mesh_memory_bytes);
  }
};

struct ClientMeasurement {
  std::vector<KeyframeCosts> keyframes;
  ClientCosts costs;
};
ClientMeasurement measureClient(const server::Hierarchy& hierarchy, const std::vector<RecordedKeyframe>& flight);
ClientCosts costsOf(const std::vector<KeyframeCosts>& keyframes, double memory_bytes);

}  // namespace foreland::lab
