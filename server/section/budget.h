// Keeps a viewer inside what it can draw and what its link carries: the tolerance rises and falls smoothly (S names
// this as future work). One owner; reads no clock: it is called once for each keyframe.
//
// Triangles follow the tolerance at once (about as tau^-1.2 on terrain), so they are steered straight to the middle of
// a band below the budget. Bytes follow with delay, and lowering tau itself costs bytes, so for them tau rises quickly
// above the band, rests within it, and falls slowly below it. Steps are bounded either way, upwards for a keyframe and
// downwards in time, so keyframes that are far apart do not make it fall more slowly; there is no integral term, hence
// nothing to overshoot. Where processors are scarce the tolerance rises by as much a keyframe, and falls slowly
// once they are free.
#pragma once

#include <cstdint>
#include <functional>

namespace foreland::server {

// What there is of the server's processors for a viewer: as much as it wants; no more than it takes now; or less.
enum class Processors : uint8_t { kFree, kTaken, kScarce };

// What a viewer can take, 0 being no limit, and what the server can give it.
struct Budget {
  uint32_t triangles = 0;
  uint32_t bytes_per_second = 0;
  Processors processors = Processors::kFree;
};

class ToleranceControl {
 public:
  // The tolerance for the next keyframe: never below `wanted_px`.
  double next(double wanted_px, const Budget& budget);
  // Takes in the size of the last keyframe: the triangles of its mesh, the bytes of its message, and the time since the
  // one before it.
  void observe(double triangles, double bytes, double interval_s);
  // Continues from `tau_px`, the tolerance that was used because the section of next()'s did not fit. Down to what it
  // was before, it may fall faster than otherwise.
  void force(double tau_px);
  // Begins anew, as before the first keyframe; what is known of the link stays.
  void restart();

  double tolerance() const { return tau_px_; }  // in force; 0 before the first keyframe

 private:
  double tau_px_ = 0;
  double unforced_px_ = 0;   // before it was forced up
  bool was_scarce_ = false;  // processors, since the tolerance was the wanted one
  double triangles_ = 0;
  double bytes_per_s_ = 0;  // smoothed over a few seconds
  double interval_s_ = 0;   // of the last keyframe
};

// The tolerance at which a section fits: tau_px if it does there, else one that is larger, at which the load is mostly
// above kMinLoad, rounded to a float; or kMaxTolerance_px, which is beyond any error on a screen and the most that a
// keyframe can carry. `load` is the share of what is allowed that the section of a tolerance takes, at most 1 if it
// fits, and infinite if it was not measured whole; it must not rise with the tolerance. `guess_px` is tried first if it
// is above tau_px. Cost: one call of `load` if the section fits at once, else about 4 and at most kMaxTries.
inline constexpr int kMaxTries = 12;
inline constexpr double kMinLoad = 0.8;
inline constexpr float kMaxTolerance_px = 1e9f;
double toleranceThatFits(double tau_px, double guess_px, const std::function<double(double tau_px)>& load);

}  // namespace foreland::server
