#include "lab/latency/judged_frames.h"

#include <cmath>
#include <cstdio>

namespace foreland::lab {

Result<JudgedFrames> JudgedFrames::atRate(double hz) {
  constexpr double kRounding = 1e-3;  // 3.333 is a third of ten
  const double one_in = std::round(kMax_hz / hz);
  if (hz >= kMin_hz && hz <= kMax_hz && std::abs(hz * one_in - kMax_hz) < kRounding * kMax_hz)
    return JudgedFrames(static_cast<uint32_t>(one_in));
  char text[160];
  std::snprintf(text, sizeof text,
                "the frames judged a second must be %g or a whole part of it, such as 5, 2, 1 or %g, not %g", kMax_hz,
                kMin_hz, hz);
  return Error{ErrorCode::kInvalidArgument, text};
}

}  // namespace foreland::lab
