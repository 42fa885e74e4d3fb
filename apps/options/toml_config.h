// Lets CLI11 read its options from a TOML file, by toml++. CLI11's own reader takes a part of TOML only, and its writer
// repeats numbers as they were given, which TOML may not allow (`.5`).
#pragma once

#include <CLI/CLI.hpp>
#include <istream>
#include <string>
#include <vector>

namespace foreland::apps {

class TomlConfig : public CLI::ConfigTOML {
 public:
  // `app`, whose options they are, must outlive it.
  explicit TomlConfig(const CLI::App& app) : app_(app) {}

  // One item for each key; lists have several inputs, empty texts and lists and a flag's `false` none, as if the option
  // were not given. Throws CLI::ConversionError, as CLI11 expects, which says what is wrong and in which line.
  std::vector<CLI::ConfigItem> from_config(std::istream& input) const override;

 private:
  const CLI::App& app_;
};

// Adds --config FILE.toml, whose keys are the app's options without their dashes.
void addConfiguration(CLI::App& app);

// All options that a file may set, with what they do, as such a file: after parsing with the values that are in force.
std::string configText(CLI::App& app);

}  // namespace foreland::apps
