// Python's web server for a folder: it answers no ranges, and leads who asks for a folder without a slash at its end to
// the folder's index.html (301).
#pragma once

#include <gtest/gtest.h>

#include <filesystem>
#include <string>

#include "tests/support/program.h"

namespace foreland::test {

class PlainWebServer {
 public:
  explicit PlainWebServer(const std::filesystem::path& folder)
      : program_("/usr/bin/python3",
                 {"-u", "-m", "http.server", "0", "--bind", "127.0.0.1", "--directory", folder.string()}) {
    const std::string line = program_.readLine(), word = " port ";
    const size_t at = line.find(word);
    EXPECT_NE(at, std::string::npos) << line;
    if (at != std::string::npos)
      address_ = "http://127.0.0.1:" + std::to_string(std::stoi(line.substr(at + word.size())));
  }
  // Without a slash at its end.
  const std::string& address() const { return address_; }

 private:
  Program program_;
  std::string address_;
};

}  // namespace foreland::test
