// Keeps a viewer inside what it can draw and what its link carries: the tolerance rises and falls smoothly (S names
// this as future work). One owner; reads no clock: it is called once for each keyframe.
//
// Triangles follow the tolerance at once (about as tau^-1.2 on terrain), so they are steered straight to the middle of
// a band below the budget. Bytes follow with delay, and lowering tau itself costs bytes, so for them tau rises quickly
// above the band, rests within it, and falls slowly below it. Steps are bounded either way; there is no integral term,
// hence nothing to overshoot.
#pragma once

#include <cstdint>
#include <functional>

namespace foreland::server {

// What a viewer can take; 0 is no limit.
struct Budget {
  uint32_t triangles = 0;
  uint32_t bytes_per_second = 0;
};

class ToleranceControl {
 public:
  // The tolerance for the next keyframe: never below `wanted_px`.
  double next(double wanted_px, const Budget& budget);
  // Takes in the size of the last keyframe: the triangles of its mesh, the bytes of its message, and the time since the
  // one before it.
  void observe(double triangles, double bytes, double interval_s);
  // Continues from `tau_px`, the tolerance that was used because the section of next()'s did not fit.
  void force(double tau_px) { tau_px_ = tau_px; }

 private:
  double tau_px_ = 0;  // in force; 0 before the first keyframe
  double triangles_ = 0;
  double bytes_per_s_ = 0;  // smoothed over a few seconds
};

// The first of tau_px, tau_px * factor, tau_px * factor^2, ... (each rounded to a float) for which `fits` holds; or the
// last of kMostRises such steps, or kMostTolerance_px, which is beyond any error on a screen and the most that a
// keyframe can carry. `fits` must hold for all tolerances above one for which it holds. Cost: one call of `fits` if it
// holds at once, else at most 2 log2(kMostRises) + 1.
inline constexpr int kMostRises = 256;
inline constexpr float kMostTolerance_px = 1e9f;
double raiseUntil(double tau_px, double factor, const std::function<bool(double tau_px)>& fits);

}  // namespace foreland::server
