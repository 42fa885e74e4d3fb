#include "apps/serve/toml_config.h"

#include <fmt/format.h>
#include <toml++/toml.h>

#include <string>
#include <string_view>

namespace foreland::apps {
namespace {

[[noreturn]] void refuse(const toml::source_position& at, std::string_view why) {
  throw CLI::ConversionError(fmt::format("--config, line {}: {}", at.line, why));
}

std::string textOf(std::string_view key, const toml::node& value) {
  if (const auto* text = value.as_string()) return text->get();
  if (const auto* number = value.as_integer()) return fmt::format("{}", number->get());
  if (const auto* number = value.as_floating_point()) return fmt::format("{}", number->get());
  refuse(value.source().begin, fmt::format("'{}' must be a text, a number, or a list of these", key));
}

CLI::ConfigItem itemOf(std::string_view key, const toml::node& value) {
  CLI::ConfigItem item;
  item.name = key;
  if (const toml::array* list = value.as_array())
    for (const toml::node& entry : *list) item.inputs.push_back(textOf(key, entry));
  else if (std::string text = textOf(key, value); !text.empty())
    item.inputs.push_back(std::move(text));
  return item;
}

}  // namespace

std::vector<CLI::ConfigItem> TomlConfig::from_config(std::istream& input) const try {
  std::vector<CLI::ConfigItem> all;
  const toml::table table = toml::parse(input);
  for (const auto& [key, value] : table)
    if (CLI::ConfigItem item = itemOf(key.str(), value); !item.inputs.empty()) all.push_back(std::move(item));
  return all;
} catch (const toml::parse_error& error) { refuse(error.source().begin, error.description()); }

}  // namespace foreland::apps
