// The options of a program as a table, read from what CLI11 was told of them (apps/options/options.h). --help is
// printed from it, and so is the JSON from which tools/make_manual.py makes the manual, man pages, shell completion and
// the schema of serve.toml. Main thread.
#pragma once

#include <CLI/CLI.hpp>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace foreland::apps {

enum class ValueKind : uint8_t { kNone, kWhole, kNumber, kText, kNumberOrText, kFile, kFolder };

struct OptionRow {
  std::vector<std::string> names;  // as they are written: -o, --output; of a positional its name
  bool is_positional = false;
  std::string value;  // what the value is called; empty for flags
  ValueKind kind = ValueKind::kNone;
  std::string default_value;                 // empty if there is none to name
  std::optional<double> above, least, most;  // which numbers are accepted
  std::vector<std::string> words;            // which words are, if only a few
  std::string pattern;                       // which texts are, as a regular expression; empty for any
  std::string description, group;
  bool is_required = false;
  bool is_repeatable = false;                // takes several values, or may be given several times
  bool takes_many_at_once = false;           // as several words behind it
  char delimiter = '\0';                     // between several values in one word, if not '\0'
  std::vector<std::string> needs, excludes;  // names of options
  bool is_in_config = false;                 // may stand in the file of --config
};

// What a command line could be, for people. `what` is empty if it goes on with the example before.
struct Example {
  std::string what, command;
};

// In the order in which the options were added; without those that are hidden, and without --help.
std::vector<OptionRow> optionTable(CLI::App& app);

// What the option's description does not say: range, default, which other options go with it. Empty, or with
// semicolons.
std::string factsOf(const OptionRow& row);

// The name, and what must be given behind it.
std::string usageOf(const std::vector<OptionRow>& rows, const std::string& name);

// For --help. `name` is what the program or subcommand is run by.
std::string helpText(CLI::App& app, const std::string& name, std::span<const Example> examples);

// The table and those of all subcommands, and what else --help says, as JSON.
std::string optionsAsJson(CLI::App& app, std::span<const Example> examples);

}  // namespace foreland::apps
