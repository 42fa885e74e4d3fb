// What programs that made a scene say of it. Main thread.
#pragma once

#include <filesystem>

#include "terrain/pipeline/build.h"

namespace foreland::apps {

// Notes and warnings on standard error, what the scene has on standard output.
void printScene(const terrain::BuildReport& report, const std::filesystem::path& output, double seconds);

}  // namespace foreland::apps
