// Lines cut into words (base/lines.h cuts text into lines), without copying: what the readers of model files share.
// Value types; one owner.
#pragma once

#include <algorithm>
#include <charconv>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "base/lines.h"

namespace foreland::terrain {

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

// What a name that ends a line may be, the likeliest first: a `#` behind a blank begins a comment, if it is not a part
// of the name. The whole, and what is before such signs, of the last ones.
inline std::vector<std::string_view> possibleNames(std::string_view line) {
  constexpr size_t kMost = 5;
  std::vector<std::string_view> names{line};
  for (size_t at = line.size(); at-- > 1 && names.size() < kMost;)
    if (line[at] == '#' && (line[at - 1] == ' ' || line[at - 1] == '\t'))
      names.push_back(line.substr(0, line.find_last_not_of(" \t", at - 1) + 1));
  return names;
}

// In small letters, as far as ASCII goes.
inline std::string lowered(std::string_view word) {
  std::string made(word);
  std::transform(made.begin(), made.end(), made.begin(),
                 [](char c) { return c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c; });
  return made;
}

// The number that the whole word spells, or nullopt. Real numbers may be infinite or NaN.
template <class T>
std::optional<T> parseNumber(std::string_view word) {
  if (word.size() > 1 && word[0] == '+' && word[1] != '-') word.remove_prefix(1);
  T value{};
  const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), value);
  if (error != std::errc() || end != word.data() + word.size() || word.empty()) return std::nullopt;
  return value;
}
// The same of an unsigned number to another base.
template <class T>
std::optional<T> parseNumber(std::string_view word, int base) {
  T value{};
  const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), value, base);
  if (error != std::errc() || end != word.data() + word.size() || word.empty()) return std::nullopt;
  return value;
}

}  // namespace foreland::terrain
