#include "apps/report/summary.h"

#include <unistd.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <string_view>

namespace foreland::apps {

namespace {

constexpr size_t kNameWidth = 12;
constexpr double kMin = 0.001;  // smaller figures tell people nothing
constexpr const char *kGreen = "\033[1;32m", *kRed = "\033[1;31m", *kEnd = "\033[0m";

std::string line(const std::string& name, const std::string& figures) {
  return name + std::string(std::max(kNameWidth, name.size() + 1) - name.size(), ' ') + figures + "\n";
}

std::string verdict(const char* colour, const std::string& word, Paint paint) {
  return paint == Paint::kColours ? colour + word + kEnd : word;
}

// With a comma after each three digits before the point.
std::string grouped(std::string number) {
  const size_t point = std::min(number.find('.'), number.size()), first = number.starts_with('-') ? 1 : 0;
  for (size_t at = point; at > first + 3; at -= 3) number.insert(at - 3, ",");
  return number;
}

}  // namespace

Paint paintFor(std::FILE* out) {
  const char *no_color = std::getenv("NO_COLOR"), *terminal = std::getenv("TERM");
  const bool is_unwanted = no_color && *no_color != '\0', is_dumb = !terminal || std::string_view(terminal) == "dumb";
  return isatty(fileno(out)) == 1 && !is_unwanted && !is_dumb ? Paint::kColours : Paint::kPlain;
}

std::string Summary::text(Paint paint) const {
  std::string out;
  for (const Line& l : lines_) out += line(l.name, l.figures);
  for (const std::string& problem : problems_) {
    const std::string word = "not well";
    out += verdict(kRed, word, paint) + std::string(kNameWidth - word.size(), ' ') + problem + "\n";
  }
  if (problems_.empty()) out += verdict(kGreen, "all is well", paint) + "\n";
  return out;
}

std::string digits(double value) {
  if (!std::isfinite(value)) return value > 0 ? "infinite" : value < 0 ? "-infinite" : "none";
  if (value == 0) return "0";
  if (std::fabs(value) < kMin) return value > 0 ? "below 0.001" : "above -0.001";
  // Rounding may give another digit before the point: 9.996 is 10.0.
  const auto decimalsOf = [](double v) { return 2 - static_cast<int>(std::floor(std::log10(std::fabs(v)))); };
  double scale = std::pow(10.0, decimalsOf(value));
  const double rounded = std::round(value * scale) / scale;
  const int decimals = std::max(decimalsOf(rounded), 0);
  std::array<char, 400> text;
  std::snprintf(text.data(), text.size(), "%.*f", decimals, rounded);
  return grouped(text.data());
}

std::string shortest(double value) {
  std::string text = digits(value);
  if (text.find('.') == std::string::npos) return text;
  text.erase(text.find_last_not_of('0') + 1);
  if (text.ends_with('.')) text.pop_back();
  return text;
}

std::string count(uint64_t value) { return grouped(std::to_string(value)); }

std::string count(uint64_t value, const std::string& noun) {
  return count(value) + " " + noun + (value == 1 ? "" : "s");
}

std::string bytesText(double bytes) {
  constexpr std::array kUnits{"bytes", "kB", "MB", "GB", "TB"};
  size_t unit = 0;
  while (unit + 1 < kUnits.size() && std::fabs(bytes) >= 999.5) bytes /= 1000, ++unit;
  return digits(bytes) + " " + kUnits[unit];
}

std::string millisecondsText(double milliseconds) {
  return std::fabs(milliseconds) < 999.5 ? digits(milliseconds) + " ms" : digits(milliseconds / 1000) + " s";
}

}  // namespace foreland::apps
