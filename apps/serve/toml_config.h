// Lets CLI11 read its options from a TOML file, by toml++. CLI11's own reader takes a part of TOML only.
#pragma once

#include <CLI/CLI.hpp>
#include <istream>
#include <vector>

namespace foreland::apps {

class TomlConfig : public CLI::ConfigTOML {
 public:
  // One item for each key; lists have several inputs, empty texts and lists none, as if the option were not given.
  // Throws CLI::ConversionError, as CLI11 expects, which says what is wrong and in which line.
  std::vector<CLI::ConfigItem> from_config(std::istream& input) const override;
};

}  // namespace foreland::apps
