// Keeps a viewer inside what it can draw and take: the tolerance rises and falls smoothly (S names this as future
// work). One owner; no clock: it is called once a keyframe.
//
// Triangles follow the tolerance at once (about as tau^-1.2 on terrain), so they are steered straight to the middle of
// a band below the budget. Bytes follow with delay, and lowering tau itself costs bytes, so for them tau rises quickly
// above the band, rests within it, and falls slowly below it. Steps are bounded either way; there is no integral term,
// hence nothing to overshoot.
#pragma once

#include <cstdint>

namespace foreland::server {

// 0: no limit.
struct Budget {
  uint32_t triangles = 0;
  uint32_t bytes_per_second = 0;
};

class ToleranceControl {
 public:
  // The tolerance for the next keyframe: never below `wanted_px`.
  double next(double wanted_px, const Budget& budget);
  // What the last keyframe came to; `interval_s` is the time since the one before.
  void observe(double triangles, double bytes, double interval_s);
  // The section did not fit: the tolerance that was used instead.
  void force(double tau_px) { tau_px_ = tau_px; }

 private:
  double tau_px_ = 0;  // in force; 0 before the first keyframe
  double triangles_ = 0;
  double bytes_per_s_ = 0;  // smoothed over a few seconds
};

}  // namespace foreland::server
