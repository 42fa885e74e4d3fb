// What leaving out hidden nodes saves and costs along a flight: the same keyframes sent twice in one run, with and
// without, and taken by a client each. Processor time of one thread, but for the rays, which the wall clock times. One
// thread.
#pragma once

#include <vector>

#include "base/time.h"
#include "lab/occlusion/predicted_views.h"
#include "server/occlusion/viewer_occlusion.h"

namespace foreland::lab {

struct BothWays {
  double without = 0, with = 0;
};

struct OcclusionCosts {
  uint64_t keyframes = 0;                     // the first one included
  BothWays nodes, first_nodes;                // of the terrain's section: mean over all keyframes; of the first
  BothWays object_nodes, first_object_nodes;  // of all objects' sections, likewise
  double hidden_objects = 0;                  // mean over all keyframes
  double object_ms = 0, first_object_ms = 0, largest_object_ms = 0;  // asking for objects: median, first, largest after
  double queries_per_keyframe = 0;                                   // of solids of objects; mean after the first
  BothWays bytes, first_bytes;          // of messages: mean over keyframes after the first; of the first
  double flight_bytes_saving = 0;       // all messages, the first included
  BothWays nodes_added;                 // mean over keyframes after the first
  double hidden_bits_per_keyframe = 0;  // to tell hidden blocks; mean over keyframes after the first
  double first_hidden_bits = 0;
  BothWays keyframe_ms, first_keyframe_ms;                       // the server's; medians
  double ray_ms = 0, first_ray_ms = 0;                           // all questions of visibility; medians
  double ray_share = 0, first_ray_share = 0;                     // of the keyframe's time; medians
  double rays_per_keyframe = 0, most_rays = 0, mrays_per_s = 0;  // mean, largest after the first; median
  double tests_per_keyframe = 0, most_tests = 0;                 // of blocks, by rays or behind horizons
  double segments_per_keyframe = 0;                              // of horizons, built; mean after the first
  uint64_t first_rays = 0, first_tests = 0, first_segments = 0;
  BothWays decode_ms, first_decode_ms, mesh_ms, first_mesh_ms;  // the client's; medians
  double viewer_occlusion_kib = 0;                              // what is kept of the viewer, at the end

  template <class Visit>
  void fields(const Visit& visit) const {
    const auto ratio = [](double a, double b) { return b > 0 ? a / b : 0; };
    visit("keyframes", keyframes);
    visit("nodes_without", nodes.without);
    visit("nodes_with", nodes.with);
    visit("saving", ratio(nodes.without, nodes.with));
    visit("first_nodes_without", first_nodes.without);
    visit("first_nodes_with", first_nodes.with);
    visit("first_section_saving", ratio(first_nodes.without, first_nodes.with));
    if (object_nodes.without > 0) {
      visit("object_nodes_without", object_nodes.without);
      visit("object_nodes_with", object_nodes.with);
      visit("object_saving", ratio(object_nodes.without, object_nodes.with));
      visit("first_object_saving", ratio(first_object_nodes.without, first_object_nodes.with));
      visit("hidden_objects", hidden_objects);
      visit("object_ms", object_ms);
      visit("first_object_ms", first_object_ms);
      visit("largest_object_ms", largest_object_ms);
      visit("queries_per_keyframe", queries_per_keyframe);
    }
    visit("bytes_without", bytes.without);
    visit("bytes_with", bytes.with);
    visit("bytes_saving", ratio(bytes.without, bytes.with));
    visit("first_bytes_without", first_bytes.without);
    visit("first_bytes_with", first_bytes.with);
    visit("first_bytes_saving", ratio(first_bytes.without, first_bytes.with));
    visit("flight_bytes_saving", flight_bytes_saving);
    visit("nodes_added_without", nodes_added.without);
    visit("nodes_added_with", nodes_added.with);
    visit("hidden_bits_per_keyframe", hidden_bits_per_keyframe);
    visit("first_hidden_bits", first_hidden_bits);
    visit("ray_ms", ray_ms);
    visit("first_ray_ms", first_ray_ms);
    visit("ray_share", ray_share);
    visit("first_ray_share", first_ray_share);
    visit("keyframe_ms_without", keyframe_ms.without);
    visit("keyframe_ms_with", keyframe_ms.with);
    visit("keyframe_cost_ratio", ratio(keyframe_ms.with, keyframe_ms.without));
    visit("first_keyframe_ms_without", first_keyframe_ms.without);
    visit("first_keyframe_ms_with", first_keyframe_ms.with);
    visit("first_keyframe_cost_ratio", ratio(first_keyframe_ms.with, first_keyframe_ms.without));
    visit("rays_per_keyframe", rays_per_keyframe);
    visit("most_rays", most_rays);
    visit("first_rays", first_rays);
    visit("mrays_per_s", mrays_per_s);
    visit("tests_per_keyframe", tests_per_keyframe);
    visit("most_tests", most_tests);
    visit("first_tests", first_tests);
    visit("segments_per_keyframe", segments_per_keyframe);
    visit("first_segments", first_segments);
    visit("decode_ms_without", decode_ms.without);
    visit("decode_ms_with", decode_ms.with);
    visit("first_decode_ms_without", first_decode_ms.without);
    visit("first_decode_ms_with", first_decode_ms.with);
    visit("mesh_ms_without", mesh_ms.without);
    visit("mesh_ms_with", mesh_ms.with);
    visit("first_mesh_ms_without", first_mesh_ms.without);
    visit("first_mesh_ms_with", first_mesh_ms.with);
    visit("viewer_occlusion_kib", viewer_occlusion_kib);
  }
};

// Checks that both ends hold the same sections. At least two views.
OcclusionCosts measureOcclusionCosts(const server::Hierarchy& hierarchy, const server::SceneOcclusion& occlusion,
                                     const PredictedFlight& flight, Duration keyframe_interval);

}  // namespace foreland::lab
