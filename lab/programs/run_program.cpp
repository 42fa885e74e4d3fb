#include "lab/programs/run_program.h"

#include <errno.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cstring>

extern char** environ;

namespace foreland::lab {

namespace {

Error failure(const std::string& program, int number) {
  const ErrorCode code = number == ENOENT ? ErrorCode::kNotFound : ErrorCode::kIo;
  return Error{code, program + ": " + std::strerror(number)};
}

std::string readAll(int fd) {
  std::string text;
  char buffer[4096];
  for (;;) {
    const ssize_t n = ::read(fd, buffer, sizeof(buffer));
    if (n > 0)
      text.append(buffer, static_cast<size_t>(n));
    else if (n == 0 || errno != EINTR)
      return text;
  }
}

}  // namespace

Result<std::string> runProgram(const std::vector<std::string>& words) {
  int ends[2];
  if (::pipe(ends) != 0) return failure(words[0], errno);
  posix_spawn_file_actions_t actions;
  posix_spawn_file_actions_init(&actions);
  posix_spawn_file_actions_adddup2(&actions, ends[1], STDOUT_FILENO);
  posix_spawn_file_actions_addclose(&actions, ends[0]);
  posix_spawn_file_actions_addclose(&actions, ends[1]);
  std::vector<char*> argv;
  for (const std::string& word : words) argv.push_back(const_cast<char*>(word.c_str()));
  argv.push_back(nullptr);
  pid_t pid = 0;
  const int refused = ::posix_spawnp(&pid, argv[0], &actions, nullptr, argv.data(), environ);
  posix_spawn_file_actions_destroy(&actions);
  ::close(ends[1]);
  std::string text = refused == 0 ? readAll(ends[0]) : "";
  ::close(ends[0]);
  if (refused != 0) return failure(words[0], refused);
  int status = 0;
  while (::waitpid(pid, &status, 0) < 0 && errno == EINTR) {}
  if (!WIFEXITED(status)) return Error{ErrorCode::kIo, words[0] + " was ended by a signal"};
  if (WEXITSTATUS(status) != 0)
    return Error{ErrorCode::kIo, words[0] + " exited with " + std::to_string(WEXITSTATUS(status))};
  return text;
}

}  // namespace foreland::lab
