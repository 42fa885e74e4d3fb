// Runs another program and takes what it prints. Blocks; any thread.
#pragma once

#include <string>
#include <vector>

#include "base/result.h"

namespace foreland::lab {

// What the program writes to stdout; its stderr is ours. words[0] is looked for in PATH. kNotFound if there is no such
// program, kIo if it could not be run or did not exit with 0.
Result<std::string> runProgram(const std::vector<std::string>& words);

}  // namespace foreland::lab
