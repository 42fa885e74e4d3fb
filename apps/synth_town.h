// The town that `foreland synth --town` makes.
#pragma once

#include <cstdint>
#include <filesystem>

#include "base/result.h"

namespace foreland::apps {

// Writes a scene of so many buildings, and prints what it made.
Status synthTown(const std::filesystem::path& output, uint32_t buildings, uint64_t seed);

}  // namespace foreland::apps
