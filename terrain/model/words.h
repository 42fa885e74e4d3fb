// Text cut into lines and lines into words, without copying: what the readers of model files share. Value types; one
// owner.
#pragma once

#include <algorithm>
#include <charconv>
#include <cstdint>
#include <optional>
#include <string_view>

namespace foreland::terrain {

// The lines of a text, without the line end ("\n" or "\r\n").
class Lines {
 public:
  explicit Lines(std::string_view text) : rest_(text) {}

  // False at the end of the text.
  bool next(std::string_view& line) {
    if (rest_.empty()) return false;
    const size_t end = rest_.find('\n');
    line = rest_.substr(0, end);
    rest_.remove_prefix(end == std::string_view::npos ? rest_.size() : end + 1);
    if (!line.empty() && line.back() == '\r') line.remove_suffix(1);
    ++number_;
    return true;
  }
  uint64_t number() const { return number_; }  // of the line last given, from 1
  std::string_view rest() const { return rest_; }

 private:
  std::string_view rest_;
  uint64_t number_ = 0;
};

// The words of a line; blanks separate them.
class Words {
 public:
  explicit Words(std::string_view line) : rest_(line) { skip(); }

  bool atEnd() const { return rest_.empty(); }
  // What is left of the line, without blanks at its ends. For names, which may contain blanks.
  std::string_view rest() const {
    const size_t last = rest_.find_last_not_of(" \t");
    return last == std::string_view::npos ? std::string_view() : rest_.substr(0, last + 1);
  }
  // The next word; empty at the end of the line.
  std::string_view next() {
    const size_t end = std::min(rest_.find_first_of(" \t"), rest_.size());
    const std::string_view word = rest_.substr(0, end);
    rest_.remove_prefix(end);
    skip();
    return word;
  }

 private:
  void skip() { rest_.remove_prefix(std::min(rest_.find_first_not_of(" \t"), rest_.size())); }

  std::string_view rest_;
};

// The number that the whole word spells, or nullopt. Real numbers may be infinite or NaN.
template <class T>
std::optional<T> parseNumber(std::string_view word) {
  if (word.size() > 1 && word[0] == '+' && word[1] != '-') word.remove_prefix(1);
  T value{};
  const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), value);
  if (error != std::errc() || end != word.data() + word.size() || word.empty()) return std::nullopt;
  return value;
}

}  // namespace foreland::terrain
