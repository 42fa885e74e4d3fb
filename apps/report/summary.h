// What a program tells a person about what it did: a line for each thing, its name and its figures, and in the last
// line whether all is well, or what is not and what to do. Any thread.
#pragma once

#include <cstdint>
#include <cstdio>
#include <string>
#include <utility>
#include <vector>

namespace foreland::apps {

enum class Paint : uint8_t { kPlain, kColours };
// Colours on a terminal, unless the environment has NO_COLOR (no-color.org) or the terminal is a dumb one.
Paint paintFor(std::FILE* out);

class Summary {
 public:
  void add(std::string name, std::string figures) { lines_.push_back({std::move(name), std::move(figures)}); }
  // Of what is not well: what that is, and what to do about it, if that does not go without saying.
  void addProblem(std::string what, const std::string& remedy = {}) {
    problems_.push_back(remedy.empty() ? std::move(what) : std::move(what) + "; " + remedy);
  }

  std::string text(Paint paint) const;

 private:
  struct Line {
    std::string name, figures;
  };
  std::vector<Line> lines_;
  std::vector<std::string> problems_;
};

// Three significant digits, never as a power of ten: 0.0123, 1.50, 386, 397,000. Below a thousandth it says so.
std::string digits(double value);
// The same without zeros at the end, as people write what they ask for: 1.5, 60.
std::string shortest(double value);
// All digits: 1,207.
std::string count(uint64_t value);
// The noun in the singular or with an s.
std::string count(uint64_t value, const std::string& noun);
std::string bytesText(double bytes);
std::string millisecondsText(double milliseconds);

}  // namespace foreland::apps
