#include "lab/programs/dialogue.h"

#include <errno.h>
#include <fcntl.h>
#include <poll.h>
#include <signal.h>
#include <spawn.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cstring>
#include <sstream>
#include <utility>
#include <vector>

namespace foreland::lab {

namespace {

int64_t nowUs() {
  const auto now = std::chrono::steady_clock::now().time_since_epoch();
  return std::chrono::duration_cast<std::chrono::microseconds>(now).count();
}

// False if nothing happens until then.
bool waitFor(int file, short events, int64_t until_us) {
  while (true) {
    const int64_t left_us = until_us - nowUs();
    if (left_us <= 0) return false;
    pollfd polled{file, events, 0};
    const int count = ::poll(&polled, 1, static_cast<int>(left_us / 1000 + 1));
    if (count > 0) return true;
    if (count < 0 && errno != EINTR) return true;  // the call that follows says what is wrong
  }
}

std::vector<std::string> wordsOf(const std::string& command) {
  std::istringstream text(command);
  std::vector<std::string> words;
  for (std::string word; text >> word;) words.push_back(word);
  return words;
}

// The child's number, or 0 and errno.
pid_t spawn(const std::vector<std::string>& words, int input, int output) {
  std::vector<char*> argv;
  for (const std::string& word : words) argv.push_back(const_cast<char*>(word.c_str()));
  argv.push_back(nullptr);
  posix_spawn_file_actions_t files;
  posix_spawn_file_actions_init(&files);
  posix_spawn_file_actions_adddup2(&files, input, STDIN_FILENO);
  posix_spawn_file_actions_adddup2(&files, output, STDOUT_FILENO);
  pid_t pid = 0;
  errno = ::posix_spawnp(&pid, argv[0], &files, nullptr, argv.data(), environ);
  posix_spawn_file_actions_destroy(&files);
  return errno == 0 ? pid : 0;
}

}  // namespace

Result<Dialogue> Dialogue::start(const std::string& command, Duration patience) {
  const std::vector<std::string> words = wordsOf(command);
  if (words.empty()) return Error{ErrorCode::kInvalidArgument, "names no program"};
  // A socket tells that nobody reads by an error; a pipe would end this process by SIGPIPE.
  int questions[2], answers[2];
  if (::socketpair(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0, questions) != 0)
    return Error{ErrorCode::kIo, std::strerror(errno)};
  if (::pipe2(answers, O_CLOEXEC) != 0) {
    const int why = errno;
    ::close(questions[0]), ::close(questions[1]);
    return Error{ErrorCode::kIo, std::strerror(why)};
  }
  const pid_t pid = spawn(words, questions[1], answers[1]);
  const int why = errno;
  ::close(questions[1]), ::close(answers[1]);
  if (pid != 0) return Dialogue(pid, questions[0], answers[0], patience);
  ::close(questions[0]), ::close(answers[0]);
  return Error{why == ENOENT ? ErrorCode::kNotFound : ErrorCode::kIo,
               "'" + words[0] + "' cannot be run: " + std::strerror(why)};
}

Dialogue::Dialogue(Dialogue&& other) noexcept
    : pid_(std::exchange(other.pid_, 0)),
      input_(std::exchange(other.input_, -1)),
      output_(std::exchange(other.output_, -1)),
      patience_(other.patience_),
      read_(std::move(other.read_)) {}

Dialogue::~Dialogue() {
  constexpr int64_t kMoment_us = 500'000;
  if (input_ >= 0) ::close(input_);
  if (pid_ != 0) {
    const int64_t until_us = nowUs() + kMoment_us;
    char rest[4096];
    while (waitFor(output_, POLLIN, until_us) && ::read(output_, rest, sizeof rest) > 0) {}
    ::kill(pid_, SIGKILL);
    while (::waitpid(pid_, nullptr, 0) < 0 && errno == EINTR) {}
  }
  if (output_ >= 0) ::close(output_);
}

Result<std::string> Dialogue::ask(const std::string& line) {
  const int64_t until_us = nowUs() + patience_.us;
  if (Status s = send(line + "\n", until_us); !s.ok()) return s.error();
  while (true) {
    if (const size_t end = read_.find('\n'); end != std::string::npos) {
      std::string answer = read_.substr(0, end);
      read_.erase(0, end + 1);
      return answer;
    }
    if (read_.size() > kMaxAnswerBytes) return Error{ErrorCode::kLimit, "its answer has no end"};
    if (!waitFor(output_, POLLIN, until_us)) {
      const std::string seconds = std::to_string(patience_.us / 1'000'000);
      return Error{ErrorCode::kIo, "there is no answer within " + seconds + " s; a program that prints must flush"};
    }
    char part[65536];
    const ssize_t size = ::read(output_, part, sizeof part);
    if (size > 0) read_.append(part, static_cast<size_t>(size));
    if (size == 0 || (size < 0 && errno != EINTR)) return ended();
  }
}

// Whoever does not read finds out of its end by the answer that does not come.
Status Dialogue::send(const std::string& text, int64_t until_us) const {
  size_t sent = 0;
  while (sent < text.size()) {
    const ssize_t size = ::send(input_, text.data() + sent, text.size() - sent, MSG_NOSIGNAL | MSG_DONTWAIT);
    if (size > 0) sent += static_cast<size_t>(size);
    if (size >= 0 || errno == EINTR) continue;
    if (errno != EAGAIN) return {};
    if (!waitFor(input_, POLLOUT, until_us)) return Error{ErrorCode::kIo, "it does not read what it is asked"};
  }
  return {};
}

// It has closed its output, so it is about to end; if not, it is ended.
Error Dialogue::ended() {
  constexpr int64_t kMoment_us = 500'000;
  ::close(std::exchange(input_, -1));
  int status = 0;
  pid_t got = 0;
  for (const int64_t until_us = nowUs() + kMoment_us; got == 0 && nowUs() < until_us;) {
    got = ::waitpid(pid_, &status, WNOHANG);
    if (got == 0) ::poll(nullptr, 0, 1);
  }
  if (got == 0) {
    ::kill(pid_, SIGKILL);
    while (::waitpid(pid_, &status, 0) < 0 && errno == EINTR) {}
  }
  pid_ = 0;
  if (WIFSIGNALED(status)) return {ErrorCode::kIo, "it was ended by signal " + std::to_string(WTERMSIG(status))};
  return {ErrorCode::kIo, "it has ended, with code " + std::to_string(WEXITSTATUS(status))};
}

}  // namespace foreland::lab
