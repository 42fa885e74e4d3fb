#include "apps/options/command_line.h"

#include <cstdio>
#include <memory>
#include <string>
#include <string_view>
#include <utility>

namespace foreland::apps {

namespace {

using Examples = std::shared_ptr<const std::vector<Example>>;

// The examples are the program's, not its subcommands'.
void printHelpFromTable(CLI::App& app, const Examples& examples) {
  app.formatter_fn([&app, examples](const CLI::App*, const std::string& name, CLI::AppFormatMode) {
    return helpText(app, name, app.get_parent() ? std::span<const Example>{} : *examples);
  });
  for (CLI::App* sub : app.get_subcommands({})) printHelpFromTable(*sub, examples);
}

// With the subcommand, if the command line has come so far.
std::string nameOf(const CLI::App& app) {
  const auto subcommands = app.get_subcommands();
  return app.get_name() + (subcommands.empty() ? "" : " " + subcommands.front()->get_name());
}

// CLI11 would print the type of a missing value, which apps/options/options.h has made a note of its own.
std::string messageOf(const CLI::ParseError& error) {
  const std::string said = error.what();
  const size_t colon = said.find(": ");
  const bool lacks_value =
      colon != std::string::npos && said.ends_with(" missing") && said.find(" required ", colon) != std::string::npos;
  return lacks_value ? said.substr(0, colon) + " needs a value" : said;
}

}  // namespace

std::optional<int> parseCommandLine(CLI::App& app, int argc, const char* const* argv, std::vector<Example> examples) {
  if (argc == 2 && std::string_view(argv[1]) == "--options-as-json") {
    std::puts(optionsAsJson(app, examples).c_str());
    return 0;
  }
  app.get_help_ptr()->description("print this, and end");
  printHelpFromTable(app, std::make_shared<const std::vector<Example>>(std::move(examples)));
  try {
    app.parse(argc, argv);
    return std::nullopt;
  } catch (const CLI::Success& asked) { return app.exit(asked); } catch (const CLI::ParseError& error) {
    const std::string name = nameOf(app);
    std::fprintf(stderr, "%s: %s (see %s --help)\n", name.c_str(), messageOf(error).c_str(), name.c_str());
    return 2;
  }
}

}  // namespace foreland::apps
