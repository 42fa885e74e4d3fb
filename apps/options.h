// Checks of command-line options that several programs share. Header only; main thread.
#pragma once

#include <CLI/CLI.hpp>
#include <cmath>
#include <cstdlib>
#include <string>

namespace foreland::apps {

// Accepts finite numbers only; CLI11's ranges let a NaN through. Text that is no number is left for CLI11 to refuse.
inline CLI::Validator isFinite() {
  return {[](std::string& text) {
            char* end = nullptr;
            const double value = std::strtod(text.c_str(), &end);
            return *end == '\0' && !std::isfinite(value) ? "'" + text + "' is not a finite number" : std::string();
          },
          "", "finite"};
}

}  // namespace foreland::apps
