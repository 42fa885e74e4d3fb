// The page of an experiment, drawn from the tables that it left in a folder. The drawing itself is done by node with
// Observable Plot (draw.mjs). Blocks; main thread.
#pragma once

#include <filesystem>
#include <string>

#include "base/result.h"

namespace foreland::lab {

// Where draw.mjs is, with the packages that it needs beside it or within it.
std::filesystem::path reportSources();

// Writes report.html into `folder`, and its figures as SVG files beside it; what it says is how many they are. Errors
// name what is missing and how to install it: the folder's results.json, node, or the packages of draw.mjs.
Result<std::string> drawReport(const std::filesystem::path& folder, const std::filesystem::path& sources);

}  // namespace foreland::lab
