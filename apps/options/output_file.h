// Checks of the path of an output file, for programs to make before they work for hours. Header only; any thread.
#pragma once

#include <filesystem>
#include <string>
#include <system_error>

#include "base/result.h"

namespace foreland::apps {

// An Error if `output` is a directory or does not lie in one. `kind` says in the message what the file would be.
inline Status checkOutput(const std::filesystem::path& output, const std::string& kind) {
  std::error_code failed;
  const std::filesystem::path folder = output.has_parent_path() ? output.parent_path() : ".";
  if (std::filesystem::is_directory(output, failed))
    return Error{ErrorCode::kInvalidArgument, output.string() + ": a directory; name the " + kind + " in it"};
  if (!std::filesystem::is_directory(folder, failed))
    return Error{ErrorCode::kNotFound, output.string() + ": there is no directory " + folder.string()};
  return {};
}

// An Error if `output` is the file `input`, whose `role` the message names.
inline Status checkApart(const std::filesystem::path& output, const std::filesystem::path& input,
                         const std::string& role) {
  std::error_code failed;
  if (std::filesystem::equivalent(input, output, failed))
    return Error{ErrorCode::kInvalidArgument, output.string() + ": is " + role + "; name another file with -o"};
  return {};
}

}  // namespace foreland::apps
