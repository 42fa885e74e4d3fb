// Today's server writes the bytes of the golden streams. If it does not, the protocol has changed: its version,
// docs/PROTOCOL.md, the decoder written from it and the streams (README.md) change in the same commit.
#include <gtest/gtest.h>

#include <fstream>
#include <iterator>

#include "tests/protocol/flight.h"

namespace foreland::test {
namespace {

std::string read(const std::string& name) {
  std::ifstream file(FORELAND_SOURCE_DIR "/tests/protocol/golden/" + name, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), {}};
}

TEST(Golden, TheServerWritesTheBytesOfItsVersion) {
  for (const GoldenFlight& flight : recordGoldenFlights()) {
    EXPECT_TRUE(flight.expected == read(flight.name + ".expected")) << flight.name << ": other sections";
    EXPECT_TRUE(std::string(flight.stream.begin(), flight.stream.end()) == read(flight.name + ".stream"))
        << flight.name << ": other bytes";
  }
}

}  // namespace
}  // namespace foreland::test
