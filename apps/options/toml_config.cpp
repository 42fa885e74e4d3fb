#include "apps/options/toml_config.h"

#include <fmt/format.h>
#include <toml++/toml.h>

#include <iterator>
#include <memory>
#include <sstream>
#include <string>
#include <string_view>

#include "apps/options/option_table.h"
#include "apps/options/options.h"

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

bool isFlag(const CLI::App& app, std::string_view key) {
  const CLI::Option* option = app.get_option_no_throw("--" + std::string(key));
  return option != nullptr && option->get_expected_max() == 0;
}

CLI::ConfigItem itemOf(const CLI::App& app, std::string_view key, const toml::node& value) {
  CLI::ConfigItem item;
  item.name = key;
  if (isFlag(app, key)) {
    const auto* is_given = value.as_boolean();
    if (is_given == nullptr) refuse(value.source().begin, fmt::format("'{}' must be true or false", key));
    if (is_given->get()) item.inputs.emplace_back("true");
  } else if (const toml::array* list = value.as_array())
    for (const toml::node& entry : *list) item.inputs.push_back(textOf(key, entry));
  else if (std::string text = textOf(key, value); !text.empty())
    item.inputs.push_back(std::move(text));
  return item;
}

bool isNumber(ValueKind kind) {
  return kind == ValueKind::kWhole || kind == ValueKind::kNumber || kind == ValueKind::kNumberOrText;
}

std::string valueText(const std::string& value, ValueKind kind) {
  const auto number = isNumber(kind) ? finiteNumber(value) : std::nullopt;
  if (number) return kind == ValueKind::kWhole ? value : plainDigits(*number);
  std::ostringstream quoted;
  const toml::value<std::string> node(value);
  quoted << toml::toml_formatter(node, toml::format_flags::none);
  return quoted.str();
}

std::string settingOf(const OptionRow& row, const CLI::Option& option) {
  std::vector<std::string> values = option.results();
  if (values.empty() && !row.default_value.empty()) values.push_back(row.default_value);
  for (std::string& value : values) value = valueText(value, row.kind);
  if (row.is_repeatable) return "[" + CLI::detail::join(values, ", ") + "]";
  return values.empty() ? "\"\"" : values.back();
}

}  // namespace

void addConfiguration(CLI::App& app) {
  app.set_config("--config", "", "read options from this TOML file; those of the command line win")
      ->type_name(file("FILE.toml"))
      ->group("Configuration");
  app.allow_config_extras(false);
  app.config_formatter(std::make_shared<TomlConfig>(app));
}

std::string configText(CLI::App& app) {
  std::string text = "# " + app.get_description() + "\n", group;
  for (const OptionRow& row : optionTable(app)) {
    if (!row.is_in_config) continue;
    if (row.group != group && !group.empty()) text += fmt::format("\n# ---- {} ----\n", row.group);
    group = row.group;
    const std::string &name = row.names.back(), key = row.is_positional ? name : name.substr(2), facts = factsOf(row);
    text += fmt::format("\n# {}{}\n{} = {}\n", row.description, facts.empty() ? "" : " [" + facts + "]", key,
                        settingOf(row, *app.get_option(name)));
  }
  return text;
}

std::vector<CLI::ConfigItem> TomlConfig::from_config(std::istream& input) const try {
  std::vector<CLI::ConfigItem> all;
  const toml::table table = toml::parse(input);
  for (const auto& [key, value] : table)
    if (CLI::ConfigItem item = itemOf(app_, key.str(), value); !item.inputs.empty()) all.push_back(std::move(item));
  return all;
} catch (const toml::parse_error& error) { refuse(error.source().begin, error.description()); }

}  // namespace foreland::apps
