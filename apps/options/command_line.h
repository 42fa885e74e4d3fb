// How every program reads its command line. Main thread.
#pragma once

#include <CLI/CLI.hpp>
#include <optional>
#include <vector>

#include "apps/options/option_table.h"

namespace foreland::apps {

// Reads the command line into what the options of `app` were bound to. Returns the exit code with which the program is
// to end at once: 0 after --help, 2 after a mistake, which was told on standard error; nothing if it is to go on. A
// program whose only argument is --options-as-json, which --help does not name, prints its options for
// tools/make_manual.py.
std::optional<int> parseCommandLine(CLI::App& app, int argc, const char* const* argv,
                                    std::vector<Example> examples = {});

}  // namespace foreland::apps
