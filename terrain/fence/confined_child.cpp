#include "terrain/fence/confined_child.h"

#include <fcntl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <csignal>
#include <cstring>
#include <string>

namespace foreland::terrain {

namespace {

[[noreturn]] void runChild(int out, const Confinement& confinement, const std::function<Bytes()>& make) {
  confine(confinement);
  const Bytes bytes = make();
  for (size_t at = 0; at < bytes.size();) {
    const ssize_t n = write(out, bytes.data() + at, bytes.size() - at);
    if (n < 0 && errno != EINTR) _exit(1);
    if (n > 0) at += static_cast<size_t>(n);
  }
  _exit(0);
}

// All until the end, or the first bytes beyond `max_bytes`.
Bytes readAll(int in, size_t max_bytes) {
  Bytes bytes;
  std::array<uint8_t, 1u << 16> block;
  while (bytes.size() <= max_bytes) {
    const ssize_t n = read(in, block.data(), block.size());
    if (n < 0 && errno == EINTR) continue;
    if (n <= 0) break;
    bytes.insert(bytes.end(), block.begin(), block.begin() + n);
  }
  return bytes;
}

Error unable(const char* what) { return {ErrorCode::kIo, std::string("cannot ") + what + ": " + std::strerror(errno)}; }

}  // namespace

Result<Bytes> inConfinedChild(const Confinement& confinement, size_t max_bytes, const std::function<Bytes()>& make) {
  std::array<int, 2> ends{};
  if (pipe2(ends.data(), O_CLOEXEC) != 0) return unable("make a pipe to a reader");
  const pid_t child = fork();
  if (child == 0) runChild(ends[1], confinement, make);
  close(ends[1]);
  if (child < 0) {
    close(ends[0]);
    return unable("start a reader");
  }
  Bytes bytes = readAll(ends[0], max_bytes);
  close(ends[0]);
  if (bytes.size() > max_bytes) kill(child, SIGKILL);
  int status = 0;
  while (waitpid(child, &status, 0) < 0 && errno == EINTR) {}
  if (bytes.size() > max_bytes)
    return Error{ErrorCode::kLimit, "its reader makes more than " + std::to_string(max_bytes) + " bytes of it"};
  if (WIFSIGNALED(status))
    return Error{ErrorCode::kIo, "its reader was ended by signal " + std::to_string(WTERMSIG(status)) + " (" +
                                     strsignal(WTERMSIG(status)) + ")"};
  if (!WIFEXITED(status) || WEXITSTATUS(status) != 0) return Error{ErrorCode::kIo, "its reader failed"};
  return bytes;
}

}  // namespace foreland::terrain
