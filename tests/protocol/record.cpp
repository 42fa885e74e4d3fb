// Writes the golden flights anew, after a change of protocol: record FOLDER (tests/protocol/golden).
#include <cstdio>
#include <fstream>

#include "tests/protocol/flight.h"

int main(int argc, char** argv) {
  if (argc != 2) {
    std::fprintf(stderr, "usage: %s FOLDER\n", argv[0]);
    return 2;
  }
  for (const foreland::test::GoldenFlight& flight : foreland::test::recordGoldenFlights()) {
    const std::string path = std::string(argv[1]) + "/" + flight.name;
    std::ofstream stream(path + ".stream", std::ios::binary), expected(path + ".expected", std::ios::binary);
    stream.write(reinterpret_cast<const char*>(flight.stream.data()),
                 static_cast<std::streamsize>(flight.stream.size()));
    expected << flight.expected;
    if (!stream.flush() || !expected.flush()) {
      std::fprintf(stderr, "cannot write %s.*\n", path.c_str());
      return 2;
    }
    std::printf("%s: %zu bytes\n", path.c_str(), flight.stream.size() + flight.expected.size());
  }
}
