// What several programs ask of their options. Header only; main thread.
#pragma once

#include <CLI/CLI.hpp>
#include <cmath>
#include <cstdlib>
#include <string>

namespace foreland::apps {

// CLI11's ranges let a NaN through, for it is not outside of them. Text that is no number at all is CLI11's to refuse.
inline CLI::Validator isFinite() {
  return {[](std::string& text) {
            char* end = nullptr;
            const double value = std::strtod(text.c_str(), &end);
            return *end == '\0' && !std::isfinite(value) ? "'" + text + "' is not a finite number" : std::string();
          },
          "", "finite"};
}

}  // namespace foreland::apps
