// Small flights whose bytes are kept as goldens: a scripted viewer, the real session in virtual time, and what the
// viewer must then hold, from refinement from scratch and the scene's own records. No code of the client takes part.
// The same bytes on every run; README.md has their layout.
#pragma once

#include <string>
#include <vector>

#include "base/bytes.h"

namespace foreland::test {

struct GoldenFlight {
  std::string name;      // of the files: NAME.stream, NAME.expected
  Bytes stream;          // every message of both directions
  std::string expected;  // a line for each keyframe
};

// CHECKs that the session's section is the one from scratch at each keyframe. Seconds.
std::vector<GoldenFlight> recordGoldenFlights();

}  // namespace foreland::test
