// What options say of their values, in a form that apps/options/option_table.h can read: --help, the manual, shell
// completion and the schema of serve.toml follow from it. Header only; main thread.
//
//   app.add_option("--tau", tau_px, "tolerance in pixels")->type_name(number("PX"))->check(within(0.01, 1000.0));
#pragma once

#include <CLI/CLI.hpp>
#include <charconv>
#include <cmath>
#include <cstdlib>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace foreland::apps {

// For Option::type_name(): what an option's value is called, behind a tabulator its kind.
inline std::string whole(const std::string& name) { return name + "\twhole"; }
inline std::string number(const std::string& name) { return name + "\tnumber"; }
inline std::string text(const std::string& name) { return name + "\ttext"; }
inline std::string numberOrText(const std::string& name) { return name + "\tnumber or text"; }
inline std::string file(const std::string& name) { return name + "\tfile"; }
inline std::string folder(const std::string& name) { return name + "\tfolder"; }

// The names of the checks below, by which a table of options knows them.
constexpr std::string_view kWithin = "within", kAbove = "above", kOneOf = "one of", kPattern = "pattern";

// The shortest digits that mean `value`, without an exponent where that is readable.
inline std::string plainDigits(double value) {
  const double size = std::abs(value);
  const auto format =
      size == 0 || (size >= 1e-4 && size < 1e15) ? std::chars_format::fixed : std::chars_format::general;
  char digits[64];
  return {digits, std::to_chars(digits, digits + sizeof digits, value, format).ptr};
}

// The number that the whole text is; nothing for text that is none, and for what is not finite.
inline std::optional<double> finiteNumber(const std::string& text) {
  char* end = nullptr;
  const double value = std::strtod(text.c_str(), &end);
  if (end == text.c_str() || *end != '\0' || !std::isfinite(value)) return std::nullopt;
  return value;
}

// Accepts finite numbers only; CLI11's ranges let a NaN through. Text that is no number is left for CLI11 to refuse.
inline CLI::Validator isFinite() {
  return {[](std::string& text) {
            char* end = nullptr;
            const double value = std::strtod(text.c_str(), &end);
            return *end == '\0' && !std::isfinite(value) ? "'" + text + "' is not a finite number" : std::string();
          },
          "", "finite"};
}

// Numbers from `least` to `most`, both included; whole ones where the type is.
template <class Number>
CLI::Validator within(Number least, Number most) {
  const std::string range = plainDigits(static_cast<double>(least)) + " to " + plainDigits(static_cast<double>(most));
  return {[=](std::string& text) {
            Number value{};
            const bool is_in =
                finiteNumber(text) && CLI::detail::lexical_cast(text, value) && value >= least && value <= most;
            return is_in ? std::string()
                         : "'" + text + "' is not " + (std::is_integral_v<Number> ? "a whole number" : "a number") +
                               " of " + range;
          },
          range, std::string(kWithin)};
}

// Numbers above `bound`, which is not included, and at most `most`, if that is given.
inline CLI::Validator above(double bound, std::optional<double> most = std::nullopt) {
  const std::string range = plainDigits(bound) + (most ? " to " + plainDigits(*most) : "");
  return {[=](std::string& text) {
            const auto value = finiteNumber(text);
            if (value && *value > bound && (!most || *value <= *most)) return std::string();
            return "'" + text + "' is not a number above " + plainDigits(bound) +
                   (most ? " and at most " + plainDigits(*most) : std::string());
          },
          range, std::string(kAbove)};
}

// One of a few words.
inline CLI::Validator oneOf(const std::vector<std::string>& words) {
  return {[words](std::string& text) {
            for (const std::string& word : words)
              if (text == word) return std::string();
            return "'" + text + "' is not one of " + CLI::detail::join(words, ", ");
          },
          CLI::detail::join(words, "|"), std::string(kOneOf)};
}

}  // namespace foreland::apps
