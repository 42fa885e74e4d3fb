// Real inputs for tests: under $FORELAND_DATA, by default ../shared/data beside the checkout. Tests that need them skip
// with the reason when they are absent.
#pragma once

#include <cstdlib>
#include <filesystem>
#include <optional>
#include <string>

namespace foreland::test {

inline std::filesystem::path dataDirectory() {
  if (const char* set = std::getenv("FORELAND_DATA")) return set;
  return std::filesystem::path(FORELAND_SOURCE_DIR) / ".." / "shared" / "data";
}

inline std::optional<std::filesystem::path> dataFile(const std::string& relative) {
  const auto path = dataDirectory() / relative;
  if (!std::filesystem::exists(path)) return std::nullopt;
  return path;
}

}  // namespace foreland::test

// First line of a test on real data: declares `name` as the path, or skips.
#define FORELAND_DATA_OR_SKIP(name, relative)                                                \
  const auto name##_found = ::foreland::test::dataFile(relative);                            \
  if (!name##_found) GTEST_SKIP() << "no real data: " << relative << " (set FORELAND_DATA)"; \
  const std::filesystem::path& name = *name##_found
