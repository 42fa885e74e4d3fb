// Another program that runs beside this one until it is stopped, such as a server. One owner.
#pragma once

#include <sys/types.h>

#include <cstdio>
#include <memory>
#include <string>
#include <vector>

#include "base/result.h"

namespace foreland::lab {

class RunningProgram {
 public:
  // Starts words[0], a path, with the other words. It ends with this process at the latest, if that is killed. An Error
  // if it cannot be started; a file that cannot be run shows as an end without output.
  static Result<RunningProgram> start(const std::vector<std::string>& words);
  RunningProgram(RunningProgram&& other) noexcept;
  RunningProgram& operator=(RunningProgram&&) = delete;
  ~RunningProgram() { stop(); }

  // The next line that it prints to stdout; empty at its end. Blocks.
  std::string readLine();
  // Asks it to end in its own time, as SIGTERM does, or ends it at once, as SIGKILL does. Waits for nothing.
  void ask();
  void kill();
  // Interrupts it, as Ctrl-C does, and waits for its end. May be called again.
  void stop();

 private:
  struct Close {
    void operator()(std::FILE* file) const { std::fclose(file); }
  };
  RunningProgram(pid_t pid, std::FILE* output) : pid_(pid), output_(output) {}

  pid_t pid_;  // 0: it has ended
  std::unique_ptr<std::FILE, Close> output_;
};

}  // namespace foreland::lab
