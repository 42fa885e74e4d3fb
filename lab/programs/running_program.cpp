#include "lab/programs/running_program.h"

#include <errno.h>
#include <fcntl.h>
#include <signal.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cstring>
#include <utility>

namespace foreland::lab {

namespace {

Error failure(const std::string& program) { return {ErrorCode::kIo, program + ": " + std::strerror(errno)}; }

}  // namespace

Result<RunningProgram> RunningProgram::start(const std::vector<std::string>& words) {
  std::vector<char*> argv;
  for (const std::string& word : words) argv.push_back(const_cast<char*>(word.c_str()));
  argv.push_back(nullptr);
  int ends[2];
  if (::pipe2(ends, O_CLOEXEC) != 0) return failure(words[0]);
  const pid_t pid = ::fork();
  if (pid < 0) return failure(words[0]);
  if (pid == 0) {  // nothing but system calls until exec, for other threads may hold locks
    ::prctl(PR_SET_PDEATHSIG, SIGTERM);
    ::dup2(ends[1], STDOUT_FILENO);
    ::execv(argv[0], argv.data());
    ::_exit(127);
  }
  ::close(ends[1]);
  return RunningProgram(pid, ::fdopen(ends[0], "r"));
}

RunningProgram::RunningProgram(RunningProgram&& other) noexcept
    : pid_(std::exchange(other.pid_, 0)), output_(std::move(other.output_)) {}

std::string RunningProgram::readLine() {
  std::string line;
  for (int c = std::fgetc(output_.get()); c != EOF && c != '\n'; c = std::fgetc(output_.get()))
    line.push_back(static_cast<char>(c));
  return line;
}

void RunningProgram::ask() {
  if (pid_ != 0) ::kill(pid_, SIGTERM);
}

void RunningProgram::kill() {
  if (pid_ != 0) ::kill(pid_, SIGKILL);
}

void RunningProgram::stop() {
  const pid_t pid = std::exchange(pid_, 0);
  if (pid == 0) return;
  ::kill(pid, SIGINT);
  while (::waitpid(pid, nullptr, 0) < 0 && errno == EINTR) {}
}

}  // namespace foreland::lab
