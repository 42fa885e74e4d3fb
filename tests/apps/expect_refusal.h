// What every program owes to bad input: exit code 2, and a message that names the thing and the way out.
#pragma once

#include <gtest/gtest.h>

#include <filesystem>
#include <string>
#include <vector>

#include "tests/support/program.h"

namespace foreland::test {

// `words` must all be in what it says.
inline void expectRefusal(const std::string& name, const std::vector<std::string>& arguments,
                          const std::vector<std::string>& words, ProgramOptions options = {}) {
  const ProgramResult result = runProgram(name, arguments, options);
  EXPECT_EQ(result.exit_code, 2) << result.output;
  for (const std::string& word : words)
    EXPECT_NE(result.output.find(word), std::string::npos) << word << " is not in: " << result.output;
}

inline size_t filesIn(const std::filesystem::path& folder) {
  size_t count = 0;
  for ([[maybe_unused]] const auto& entry : std::filesystem::directory_iterator(folder)) ++count;
  return count;
}

}  // namespace foreland::test
