// Whether leaving out hidden nodes shows, and how much at best it could save: some keyframes of a flight, and a frame
// before each of them, are put before rays and lines of sight that share nothing with what the server asks. Uses all
// processors.
#pragma once

#include <vector>

#include "lab/occlusion/pixels.h"
#include "lab/occlusion/possible.h"
#include "lab/sections/flight_views.h"
#include "server/section/hierarchy.h"
#include "server/section/sender.h"

namespace foreland::lab {

struct OcclusionJudgement {
  uint64_t judged_keyframes = 0, judged_frames = 0;
  PossibleNodes possible, first_possible;  // sums over the keyframes judged; of the first
  double nodes_with = 0;                   // where hidden nodes are left out; sum over the keyframes judged
  PixelCounts keyframes, frames;
  uint64_t late_reveals = 0;      // nodes left out at a keyframe judged and at the one before, visible at both
  uint64_t withheld_visible = 0;  // nodes left out at a keyframe judged and visible at it
  double min_weight = 1, largest_weight = 0;  // of the frames judged

  template <class Visit>
  void fields(const Visit& visit) const {
    const auto share = [](uint64_t part, uint64_t all) {
      return all > 0 ? static_cast<double>(part) / static_cast<double>(all) : 0;
    };
    const auto ratio = [](double a, double b) { return b > 0 ? a / b : 0; };
    visit("judged_saving", ratio(possible.all, nodes_with));
    visit("possible_saving", ratio(possible.all, possible.vertices));
    visit("possible_saving_raised", ratio(possible.all, possible.raised));
    visit("possible_saving_supports", ratio(possible.all, possible.supports));
    visit("possible_saving_blocks", ratio(possible.all, possible.blocks));
    visit("possible_saving_region", ratio(possible.all, possible.region));
    visit("first_possible_saving", ratio(first_possible.all, first_possible.vertices));
    visit("first_possible_saving_region", ratio(first_possible.all, first_possible.region));
    visit("visible_nodes_share", ratio(possible.visible, possible.all));
    visit("visible_pixels_over_tau_keyframes", share(keyframes.visible_over_tau_hidden, keyframes.pixels));
    visit("visible_pixels_over_tau_frames", share(frames.visible_over_tau_hidden, frames.pixels));
    visit("drawn_pixels_over_tau_keyframes", share(keyframes.drawn_over_tau_hidden, keyframes.pixels));
    visit("drawn_pixels_over_tau_frames", share(frames.drawn_over_tau_hidden, frames.pixels));
    visit("hidden_objects_seen_keyframes", keyframes.hidden_objects_seen);
    visit("hidden_objects_seen_frames", frames.hidden_objects_seen);
    visit("late_reveals", late_reveals);
    visit("withheld_visible", withheld_visible);
    visit("judged_keyframes", judged_keyframes);
    visit("judged_frames", judged_frames);
    visit("judged_weight_least", min_weight);
    visit("judged_weight_largest", largest_weight);
    visit("pixels_keyframes", keyframes.pixels);
    visit("pixels_over_tau_with_keyframes", keyframes.visible_over_tau);
    visit("pixels_over_tau_without_keyframes", keyframes.visible_over_tau_without);
    visit("max_error_px_keyframes", keyframes.max_px);
    visit("pixels_frames", frames.pixels);
    visit("pixels_over_tau_with_frames", frames.visible_over_tau);
    visit("pixels_over_tau_without_frames", frames.visible_over_tau_without);
    visit("max_error_px_frames", frames.max_px);
  }
};

struct JudgeOptions {
  size_t keyframes = 4;  // beside the first one; evenly spread
};

// What is judged: which blocks of the terrain are called hidden, and which objects; null: none.
struct Visibility {
  proto::BlockVisibility& blocks;
  server::ObjectVisibility* objects = nullptr;
};

// Flies the views, which are those of the keyframes of `path`, with `visibility` and without. An Error if the scene
// does not fit into memory.
Result<OcclusionJudgement> judgeOcclusion(const server::Hierarchy& hierarchy, const Visibility& visibility,
                                          const std::vector<proto::View>& views, const proto::Path& path,
                                          const FlightOptions& flight, const JudgeOptions& options);

}  // namespace foreland::lab
