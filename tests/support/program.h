// Runs the programs of bin/ as people run them.
#pragma once

#include <signal.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cstdint>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <string>
#include <utility>
#include <vector>

#include "base/check.h"

namespace foreland::test {

enum class Streams : uint8_t { kBoth, kOutputOnly };  // what is captured; errors go to the test's own otherwise

struct ProgramOptions {
  Streams streams = Streams::kBoth;
  uint64_t largest_file_bytes = RLIM_INFINITY;  // a write beyond it fails, as on a full disk
};

// A running program foreland-NAME, or one that is named by its path. The destructor kills it if it has not ended.
class Program {
 public:
  Program(const std::string& name, std::vector<std::string> arguments, ProgramOptions options = {}) {
    const std::string path =
        name.starts_with('/') ? name : (std::filesystem::path(FORELAND_BIN_DIR) / ("foreland-" + name)).string();
    arguments.insert(arguments.begin(), path);
    std::vector<char*> words;
    for (std::string& a : arguments) words.push_back(a.data());
    words.push_back(nullptr);
    int ends[2];
    CHECK_EQ(::pipe(ends), 0);
    pid_ = ::fork();
    if (pid_ == 0) {
      ::dup2(ends[1], STDOUT_FILENO);
      if (options.streams == Streams::kBoth) ::dup2(ends[1], STDERR_FILENO);
      ::close(ends[0]);
      ::signal(SIGXFSZ, SIG_IGN);
      const rlimit files{options.largest_file_bytes, options.largest_file_bytes};
      if (options.largest_file_bytes != RLIM_INFINITY) ::setrlimit(RLIMIT_FSIZE, &files);
      ::execv(path.c_str(), words.data());
      ::_exit(127);
    }
    ::close(ends[1]);
    output_ = ::fdopen(ends[0], "r");
  }
  ~Program() {
    if (!ended_) ::kill(pid_, SIGKILL), wait();
    std::fclose(output_);
  }
  Program(const Program&) = delete;
  Program& operator=(const Program&) = delete;

  // The next line of output; empty at the end.
  std::string readLine() {
    std::string line;
    for (int c = std::fgetc(output_); c != EOF && c != '\n'; c = std::fgetc(output_))
      line.push_back(static_cast<char>(c));
    return line;
  }
  std::string readToEnd() {
    std::string all;
    for (int c = std::fgetc(output_); c != EOF; c = std::fgetc(output_)) all.push_back(static_cast<char>(c));
    return all;
  }
  void signal(int number) { ::kill(pid_, number); }
  pid_t pid() const { return pid_; }
  // A size in /proc/PID/status (proc(5)), such as "VmRSS"; -1 if there is none.
  int64_t kibibytes(const std::string& field) const {
    std::ifstream status("/proc/" + std::to_string(pid_) + "/status");
    for (std::string line; std::getline(status, line);)
      if (line.starts_with(field + ":")) return std::stoll(line.substr(field.size() + 1));
    return -1;
  }
  // Waits for the program's end. Returns the exit code, or -1 if a signal ended it.
  int wait() {
    int status = 0;
    ::waitpid(pid_, &status, 0);
    ended_ = true;
    return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
  }

 private:
  pid_t pid_ = -1;
  bool ended_ = false;
  std::FILE* output_ = nullptr;
};

struct ProgramResult {
  int exit_code = -1;
  std::string output;
};

inline ProgramResult runProgram(const std::string& name, std::vector<std::string> arguments,
                                ProgramOptions options = {}) {
  Program program(name, std::move(arguments), options);
  std::string output = program.readToEnd();
  return {program.wait(), std::move(output)};
}

// The port in the line in which a server prints its address; 0 if there is none.
inline uint16_t portOf(const std::string& line) {
  const size_t at = line.rfind(':');
  return at == std::string::npos ? uint16_t{0} : static_cast<uint16_t>(std::stoi(line.substr(at + 1)));
}

}  // namespace foreland::test
