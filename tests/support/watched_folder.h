// A temporary folder that tells what is done in it: the kernel does (inotify), so nothing is overlooked. One owner.
#pragma once

#include <sys/inotify.h>
#include <unistd.h>

#include <array>
#include <filesystem>
#include <string>

#include "base/check.h"
#include "tests/support/files.h"

namespace foreland::test {

class WatchedFolder {
 public:
  WatchedFolder() : watch_(inotify_init1(IN_NONBLOCK | IN_CLOEXEC)) {
    CHECK_GE(inotify_add_watch(watch_, folder_.path().c_str(), IN_OPEN | IN_ACCESS | IN_CREATE | IN_MODIFY), 0);
  }
  ~WatchedFolder() { close(watch_); }
  WatchedFolder(const WatchedFolder&) = delete;
  WatchedFolder& operator=(const WatchedFolder&) = delete;

  const std::filesystem::path& path() const { return folder_.path(); }

  // Which of its files were opened or made since the last call, and whether it was listed: "" if nothing was done.
  std::string events() const {
    std::string out;
    alignas(inotify_event) std::array<char, 4096> buffer;
    for (ssize_t n; (n = read(watch_, buffer.data(), buffer.size())) > 0;)
      for (ssize_t at = 0; at < n;) {
        const auto* event = reinterpret_cast<const inotify_event*>(buffer.data() + at);
        out += event->len > 0 ? event->name : "the folder";
        out += event->mask & IN_CREATE ? " made; " : " opened; ";
        at += static_cast<ssize_t>(sizeof(inotify_event) + event->len);
      }
    return out;
  }

 private:
  TemporaryFolder folder_;
  int watch_;
};

}  // namespace foreland::test
