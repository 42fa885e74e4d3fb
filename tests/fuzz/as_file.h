// Bytes of a fuzzer as a file, for what opens files by path.
#pragma once

#include <sys/mman.h>
#include <unistd.h>

#include <string>

#include "base/bytes.h"
#include "base/check.h"

namespace foreland::test {

// Calls visit(path); the file is gone afterwards.
template <class Visit>
void asFile(ByteSpan bytes, const Visit& visit) {
  const int file = memfd_create("fuzzed", 0);
  CHECK_GE(file, 0);
  CHECK_EQ(write(file, bytes.data(), bytes.size()), static_cast<ssize_t>(bytes.size()));
  visit("/proc/self/fd/" + std::to_string(file));
  close(file);
}

}  // namespace foreland::test
