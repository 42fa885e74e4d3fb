#include "apps/options/option_table.h"

#include <algorithm>
#include <charconv>
#include <nlohmann/json.hpp>
#include <string_view>
#include <utility>

#include "apps/options/options.h"

namespace foreland::apps {

namespace {

using Json = nlohmann::ordered_json;

constexpr size_t kWidth = 100, kColumn = 32;

std::string joined(const std::vector<std::string>& words, const char* between) {
  return CLI::detail::join(words, between);
}

ValueKind kindNamed(std::string_view name) {
  if (name == "whole" || name == "INT" || name == "UINT") return ValueKind::kWhole;
  if (name == "number" || name == "FLOAT") return ValueKind::kNumber;
  if (name == "number or text") return ValueKind::kNumberOrText;
  if (name == "file") return ValueKind::kFile;
  if (name == "folder") return ValueKind::kFolder;
  return ValueKind::kText;
}

const char* nameOf(ValueKind kind) {
  switch (kind) {
    case ValueKind::kNone:
      return "flag";
    case ValueKind::kWhole:
      return "whole";
    case ValueKind::kNumber:
      return "number";
    case ValueKind::kText:
      return "text";
    case ValueKind::kNumberOrText:
      return "number or text";
    case ValueKind::kFile:
      return "file";
    case ValueKind::kFolder:
      return "folder";
  }
  return "";
}

// The number that a range of apps/options/options.h begins with, which is removed with what joins it to the next.
std::optional<double> takeNumber(std::string_view& range) {
  double value = 0;
  const auto [end, error] = std::from_chars(range.data(), range.data() + range.size(), value);
  if (error != std::errc{}) return std::nullopt;
  range.remove_prefix(static_cast<size_t>(end - range.data()));
  if (range.starts_with(" to ")) range.remove_prefix(4);
  return value;
}

void addChecks(CLI::Option& option, OptionRow& row) {
  const auto checkNamed = [&](std::string_view name) -> std::string {
    try {
      return option.get_validator(std::string(name))->get_description();
    } catch (const CLI::OptionNotFound&) { return {}; }
  };
  const std::string within = checkNamed(kWithin), above = checkNamed(kAbove);
  std::string_view range = within.empty() ? std::string_view(above) : within;
  (within.empty() ? row.above : row.least) = takeNumber(range);
  row.most = takeNumber(range);
  if (const std::string words = checkNamed(kOneOf); !words.empty()) row.words = CLI::detail::split(words, '|');
  row.pattern = checkNamed(kPattern);
}

// `PX<tabulator>number`, as apps/options/options.h writes it; otherwise CLI11's own name of the type. CLI11 appends the
// checks.
void addValue(const CLI::Option& option, OptionRow& row) {
  if (option.get_items_expected_max() == 0) return;
  const std::string type = option.get_type_name();
  const size_t tabulator = type.find('\t'), kind = tabulator == std::string::npos ? 0 : tabulator + 1;
  row.kind = kindNamed(type.substr(kind, type.find(':', kind) - kind));
  if (kind > 0)
    row.value = type.substr(0, tabulator);
  else if (!row.words.empty())
    row.value = joined(row.words, "|");
  else
    row.value = row.kind == ValueKind::kText ? "TEXT" : "N";
}

std::vector<std::string> namesOf(const std::set<CLI::Option*>& options) {
  std::vector<std::string> names;
  for (const CLI::Option* option : options) names.push_back(option->get_name());
  std::sort(names.begin(), names.end());
  return names;
}

OptionRow rowOf(CLI::Option& option) {
  OptionRow row;
  row.is_positional = !option.nonpositional();
  for (const std::string& name : option.get_snames()) row.names.push_back("-" + name);
  for (const std::string& name : option.get_lnames()) row.names.push_back("--" + name);
  if (row.is_positional) row.names.push_back(option.get_name(true));
  addChecks(option, row);
  addValue(option, row);
  if (row.kind != ValueKind::kNone) row.default_value = option.get_default_str();
  row.description = option.get_description();
  row.group = option.get_group();
  row.is_required = option.get_required();
  row.is_repeatable = option.get_items_expected_max() > 1;
  row.takes_many_at_once = row.is_repeatable && option.get_allow_extra_args() && option.get_delimiter() == '\0';
  row.delimiter = option.get_delimiter();
  row.needs = namesOf(option.get_needs());
  row.excludes = namesOf(option.get_excludes());
  row.is_in_config = option.get_configurable();
  return row;
}

// Appends `text` in lines of at most kWidth characters, each behind `indent` spaces; the first line has begun already.
void addWrapped(std::string_view text, size_t indent, std::string& out) {
  size_t column = indent;
  bool is_first = true;
  for (const std::string& word : CLI::detail::split(std::string(text), ' ')) {
    if (!is_first && column + 1 + word.size() > kWidth) {
      out += "\n" + std::string(indent, ' ');
      column = indent;
    } else if (!is_first) {
      out += ' ';
      ++column;
    }
    out += word;
    column += word.size();
    is_first = false;
  }
  out += "\n";
}

// `-o, --output FILE`; long names stand in one column.
std::string signOf(const OptionRow& row) {
  if (row.is_positional) return row.names.front() + (row.is_repeatable ? "..." : "");
  const bool has_short = !row.names.front().starts_with("--");
  return (has_short ? "" : "    ") + joined(row.names, ", ") + (row.value.empty() ? "" : " " + row.value);
}

void addRow(const OptionRow& row, std::string& out) {
  const std::string sign = "  " + signOf(row);
  out += sign;
  out += sign.size() + 2 > kColumn ? "\n" + std::string(kColumn, ' ') : std::string(kColumn - sign.size(), ' ');
  const std::string facts = factsOf(row);
  addWrapped(row.description + (facts.empty() ? "" : " [" + facts + "]"), kColumn, out);
}

Json jsonOf(const OptionRow& row) {
  Json json{{"names", row.names}, {"positional", row.is_positional}, {"type", nameOf(row.kind)}, {"value", row.value}};
  const auto addNumber = [&](const char* key, const std::optional<double>& number) {
    if (!number) return;
    if (row.kind == ValueKind::kWhole)
      json[key] = static_cast<int64_t>(*number);
    else
      json[key] = *number;
  };
  if (!row.default_value.empty()) json["default"] = row.default_value;
  addNumber("above", row.above);
  addNumber("least", row.least);
  addNumber("most", row.most);
  if (!row.words.empty()) json["words"] = row.words;
  if (!row.pattern.empty()) json["pattern"] = row.pattern;
  json["description"] = row.description;
  json["facts"] = factsOf(row);
  json["group"] = row.group;
  json["required"] = row.is_required;
  json["repeatable"] = row.is_repeatable;
  json["many_at_once"] = row.takes_many_at_once;
  if (row.delimiter != '\0') json["delimiter"] = std::string(1, row.delimiter);
  if (!row.needs.empty()) json["needs"] = row.needs;
  if (!row.excludes.empty()) json["excludes"] = row.excludes;
  json["in_config"] = row.is_in_config;
  return json;
}

Json jsonOf(CLI::App& app, const std::string& name, std::span<const Example> examples) {
  const std::vector<OptionRow> rows = optionTable(app);
  Json json{{"name", name}, {"summary", app.get_description()}, {"usage", usageOf(rows, name)}};
  json["options"] = Json::array();
  for (const OptionRow& row : rows) json["options"].push_back(jsonOf(row));
  json["examples"] = Json::array();
  for (const Example& example : examples)
    json["examples"].push_back({{"what", example.what}, {"command", example.command}});
  json["footer"] = app.get_footer();
  json["subcommands"] = Json::array();
  for (CLI::App* sub : app.get_subcommands({}))
    json["subcommands"].push_back(jsonOf(*sub, name + " " + sub->get_name(), {}));
  return json;
}

void addSubcommands(CLI::App& app, std::string& out) {
  const auto subcommands = app.get_subcommands({});
  if (subcommands.empty()) return;
  out += "\n";
  for (const CLI::App* sub : subcommands) {
    out += "  " + sub->get_name() + std::string(14 - std::min<size_t>(13, sub->get_name().size()), ' ');
    addWrapped(sub->get_description(), 16, out);
  }
}

}  // namespace

std::vector<OptionRow> optionTable(CLI::App& app) {
  std::vector<OptionRow> rows;
  for (CLI::Option* option : app.get_options())
    if (!option->get_group().empty() && option != app.get_help_ptr()) rows.push_back(rowOf(*option));
  return rows;
}

std::string factsOf(const OptionRow& row) {
  std::vector<std::string> facts;
  if (row.least && row.most) facts.push_back(plainDigits(*row.least) + " to " + plainDigits(*row.most));
  if (row.above)
    facts.push_back("above " + plainDigits(*row.above) + (row.most ? ", at most " + plainDigits(*row.most) : ""));
  if (!row.words.empty() && row.value != joined(row.words, "|")) facts.push_back(joined(row.words, ", "));
  if (!row.default_value.empty()) facts.push_back("default " + row.default_value);
  if (row.delimiter != '\0' && row.is_repeatable)
    facts.emplace_back("several with commas between");
  else if (row.is_repeatable && !row.is_positional)
    facts.emplace_back("may be repeated");
  if (!row.needs.empty()) facts.push_back("with " + joined(row.needs, " and "));
  if (!row.excludes.empty()) facts.push_back("not with " + joined(row.excludes, " or "));
  return joined(facts, "; ");
}

std::string usageOf(const std::vector<OptionRow>& rows, const std::string& name) {
  std::string usage = name;
  for (const OptionRow& row : rows)
    if (row.is_positional) {
      const std::string sign = signOf(row);
      usage += row.is_required ? " " + sign : " [" + sign + "]";
    }
  for (const OptionRow& row : rows)
    if (!row.is_positional && row.is_required) usage += " " + row.names.front() + " " + row.value;
  const auto is_optional = [](const OptionRow& row) { return !row.is_positional && !row.is_required; };
  return std::any_of(rows.begin(), rows.end(), is_optional) ? usage + " [OPTION]..." : usage;
}

std::string helpText(CLI::App& app, const std::string& name, std::span<const Example> examples) {
  const std::vector<OptionRow> rows = optionTable(app);
  std::string out = app.get_description() + "\n\nusage: " + usageOf(rows, name);
  out += app.get_subcommands({}).empty() ? "\n" : " SUBCOMMAND ...\n";
  addSubcommands(app, out);
  std::vector<std::string> groups;
  for (const OptionRow& row : rows)
    if (std::find(groups.begin(), groups.end(), row.group) == groups.end()) groups.push_back(row.group);
  for (const std::string& group : groups) {
    out += group == "Options" ? "\n" : "\n" + group + "\n";
    for (const OptionRow& row : rows)
      if (row.group == group) addRow(row, out);
  }
  if (rows.empty()) out += "\n";
  out += "  -h, --help" + std::string(kColumn - 12, ' ') + "print this, and end\n";
  if (!examples.empty()) out += "\nExamples\n";
  for (const Example& example : examples)
    out += (example.what.empty() ? "" : "  " + example.what + "\n") + "      " + example.command + "\n";
  if (!app.get_footer().empty()) out += app.get_footer() + "\n";
  return out;
}

std::string optionsAsJson(CLI::App& app, std::span<const Example> examples) {
  return jsonOf(app, app.get_name(), examples).dump(1, ' ', false, Json::error_handler_t::replace);
}

}  // namespace foreland::apps
