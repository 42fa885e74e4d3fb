// The link of an experiment: its options, and the links that they ask for. Main thread.
#pragma once

#include <CLI/CLI.hpp>
#include <filesystem>
#include <string>

#include "base/fnv1a.h"
#include "base/result.h"
#include "sim/link_models.h"

namespace foreland::apps {

struct LinkArguments {
  std::string link;  // a model's name, or `trace`
  std::filesystem::path trace_up, trace_down;
};

// --link, with `usual` if it is not given, --trace-up and --trace-down.
void addLinkOptions(CLI::App& app, LinkArguments& args, const char* usual);
// Errors name the link, the option that is missing, or the file and line that is wrong.
Result<sim::LinkPair> linksOf(const LinkArguments& args);

// A link with the latency of lab/README.md and a rate that was recorded.
Result<sim::LinkPair> recordedLink(const std::filesystem::path& up, const std::filesystem::path& down);
// Adds what the recordings carry, if there are any, for the names of their files say too little.
void addRecordings(const sim::LinkPair& links, Fnv1a& hash);

}  // namespace foreland::apps
