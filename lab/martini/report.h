// `foreland bench refine`: refinement from scratch on one core, beside MARTINI, in C++ and in JavaScript, on the same
// heights in the same run. What each key means: lab/README.md. Blocks for about a minute.
#pragma once

#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "proto/refine/metric/metric.h"
#include "server/section/hierarchy.h"

namespace foreland::lab {

// `views` are those of a flight; `martini_folder` holds martini.mjs and, once installed, node_modules. Without them
// MARTINI is measured in C++ alone: the report has `martini_javascript` null and the reason in
// `martini_javascript_skipped`.
nlohmann::ordered_json refineReport(const std::shared_ptr<const terrain::Scene>& scene,
                                    const std::vector<proto::View>& views, const std::filesystem::path& martini_folder);

// Where martini.mjs lies.
std::filesystem::path martiniSources();

}  // namespace foreland::lab
