// What programs that write a file ask of its path before they work for hours. Header only; any thread.
#pragma once

#include <filesystem>
#include <string>
#include <system_error>

#include "base/result.h"

namespace foreland::apps {

// Whether `output` can be the name of a file: it is no directory, and lies in one. `kind` is what it will be.
inline Status checkOutput(const std::filesystem::path& output, const std::string& kind) {
  std::error_code failed;
  const std::filesystem::path folder = output.has_parent_path() ? output.parent_path() : ".";
  if (std::filesystem::is_directory(output, failed))
    return Error{ErrorCode::kInvalidArgument, output.string() + ": a directory; name the " + kind + " in it"};
  if (!std::filesystem::is_directory(folder, failed))
    return Error{ErrorCode::kNotFound, output.string() + ": there is no directory " + folder.string()};
  return {};
}

// Whether it is another file than `input`. `role` is what that one is.
inline Status checkApart(const std::filesystem::path& output, const std::filesystem::path& input,
                         const std::string& role) {
  std::error_code failed;
  if (std::filesystem::equivalent(input, output, failed))
    return Error{ErrorCode::kInvalidArgument, output.string() + ": is " + role + "; name another file with -o"};
  return {};
}

}  // namespace foreland::apps
