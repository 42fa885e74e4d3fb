// Runs a fuzz target over the files of a folder: its corpus, with the inputs that fuzzers once found.
//
//   fuzz_replay TARGET FOLDER...
//
// Exits 1 if the folders are empty or there is no such target.
#include <cstdint>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <string_view>
#include <vector>

#include "tests/fuzz/targets.h"  // written by CMake: FORELAND_FUZZ_TARGETS(DO), which calls DO(NAME) for each

#define DECLARE(name) extern "C" int fuzz_##name(const uint8_t* data, size_t size);
FORELAND_FUZZ_TARGETS(DECLARE)
#undef DECLARE

namespace {

using Target = int (*)(const uint8_t*, size_t);

Target targetNamed(std::string_view wanted) {
#define FIND(name) \
  if (wanted == #name) return fuzz_##name;
  FORELAND_FUZZ_TARGETS(FIND)
#undef FIND
  return nullptr;
}

}  // namespace

int main(int argc, char** argv) {
  const Target target = argc > 1 ? targetNamed(argv[1]) : nullptr;
  if (target == nullptr) {
    std::fputs("usage: fuzz_replay TARGET FOLDER...\n", stderr);
    return 1;
  }
  size_t count = 0;
  for (int i = 2; i < argc; ++i)
    for (const auto& entry : std::filesystem::directory_iterator(argv[i])) {
      std::ifstream file(entry.path(), std::ios::binary);
      const std::vector<char> bytes((std::istreambuf_iterator<char>(file)), {});
      // A copy of the exact size, so that a sanitizer sees each byte read beyond.
      const std::vector<uint8_t> exact(bytes.begin(), bytes.end());
      target(exact.data(), exact.size());
      ++count;
    }
  std::printf("%zu inputs\n", count);
  return count == 0 ? 1 : 0;
}
