#include "lab/apps/experiment_file.h"

#include <toml++/toml.h>

#include <algorithm>
#include <array>
#include <optional>
#include <string_view>

#include "lab/tables.h"

namespace foreland::apps {

namespace {

// Options of the commands that the whole experiment has, that would not change its results, or whose results differ
// from run to run.
constexpr std::array<std::string_view, 8> kNotOfRuns{"out",          "threads", "seed", "json",
                                                     "most-viewers", "real",    "help", "cells"};

// Reads one file; the first thing that is wrong is kept, and what is read after it counts for nothing.
class Reader {
 public:
  explicit Reader(const std::filesystem::path& path) : path_(path) {}

  Result<ExperimentFile> read() try {
    if (!std::filesystem::exists(path_))
      return Error{ErrorCode::kNotFound, "cannot open the experiment '" + path_.string() + "'"};
    const toml::table file = toml::parse_file(path_.string());
    readHead(file);
    readRuns(file);
    if (wrong_) return *wrong_;
    return std::move(result_);
  } catch (const toml::parse_error& error) { return wrong(error.source().begin, std::string(error.description())); }

 private:
  Error wrong(const toml::source_position& at, const std::string& why) const {
    return {ErrorCode::kInvalidArgument, path_.string() + ":" + std::to_string(at.line) + ": " + why};
  }
  void refuse(const toml::node& node, const std::string& why) {
    if (!wrong_) wrong_ = wrong(node.source().begin, why);
  }

  void readHead(const toml::table& file) {
    for (const auto& [key, value] : file) {
      if (key == "experiment" && value.is_string())
        result_.experiment = value.as_string()->get();
      else if (key == "seeds")
        readSeeds(value);
      else if (key == "metrics")
        result_.metrics = texts(key.str(), value);
      else if (key != "all" && key != "run")
        refuse(value,
               "unknown key '" + std::string(key.str()) + "'; there are experiment, seeds, metrics, [all], [[run]]");
    }
    if (result_.experiment != "latency" && result_.experiment != "load" && result_.experiment != "tiles")
      refuse(file, "experiment = must be \"latency\", \"load\" or \"tiles\"");
  }

  void readSeeds(const toml::node& value) {
    result_.seeds.clear();
    const toml::array none;
    for (const toml::node& seed : value.is_array() ? *value.as_array() : none) {
      const auto* number = seed.as_integer();
      if (!number || number->get() < 0) return refuse(seed, "'seeds' must be whole numbers, 0 or more");
      result_.seeds.push_back(static_cast<uint64_t>(number->get()));
    }
    if (result_.seeds.empty()) refuse(value, "'seeds' must be a list of whole numbers, such as [1, 2]");
  }

  void readRuns(const toml::table& file) {
    const toml::table none;
    const toml::node* all = file.get("all");
    if (all && !all->is_table()) refuse(*all, "'all' must be a table: [all]");
    const toml::node* runs = file.get("run");
    if (!runs || !runs->is_array() || runs->as_array()->empty())
      return refuse(runs ? *runs : static_cast<const toml::node&>(file), "there is no [[run]]");
    for (const toml::node& run : *runs->as_array())
      if (run.is_table())
        readRun(*run.as_table(), all && all->is_table() ? *all->as_table() : none);
      else
        refuse(run, "'run' must be tables: [[run]]");
  }

  // What is said of all runs holds unless the run says otherwise.
  void readRun(const toml::table& table, const toml::table& all) {
    ExperimentFile::Run run;
    run.line = static_cast<int>(table.source().begin.line);
    if (const auto* name = table.get_as<std::string>("name")) run.name = name->get();
    const auto isUsable = [](char c) { return std::isalnum(static_cast<unsigned char>(c)) || c == '_' || c == '-'; };
    if (run.name.empty() || !std::all_of(run.name.begin(), run.name.end(), isUsable))
      refuse(table, "each [[run]] needs a name of letters, digits, _ and -, for its folder");
    for (const ExperimentFile::Run& other : result_.runs)
      if (other.name == run.name) refuse(table, "two runs are called '" + run.name + "'");
    for (const auto& [key, value] : all)
      if (!table.contains(key)) addOption(key.str(), value, run.options);
    for (const auto& [key, value] : table)
      if (key != "name") addOption(key.str(), value, run.options);
    if (!table.contains("scene") && !all.contains("scene"))
      refuse(table,
             "run '" + run.name + "': there is no scene; name its file as scene = \"FILE.fls\", here or under [all]");
    result_.runs.push_back(std::move(run));
  }

  void addOption(std::string_view key, const toml::node& value, std::vector<std::string>& options) {
    if (std::find(kNotOfRuns.begin(), kNotOfRuns.end(), key) != kNotOfRuns.end())
      return refuse(value, "'" + std::string(key) + "' is no key of a run");
    if (const auto* flag = value.as_boolean()) {
      if (flag->get()) options.push_back("--" + std::string(key));
      return;
    }
    std::string joined;
    for (const std::string& text : texts(key, value)) joined += (joined.empty() ? "" : ",") + text;
    if (key == "scene") return (void)options.insert(options.begin(), joined);  // lists would take it for their own
    options.push_back("--" + std::string(key) + "=" + joined);
  }

  // A text or a number, or a list of these.
  std::vector<std::string> texts(std::string_view key, const toml::node& value) {
    std::vector<std::string> all;
    if (!value.is_array()) return {textOf(key, value)};
    for (const toml::node& entry : *value.as_array()) all.push_back(textOf(key, entry));
    return all;
  }

  std::string textOf(std::string_view key, const toml::node& value) {
    if (const auto* text = value.as_string()) return text->get();
    if (const auto* number = value.as_integer()) return std::to_string(number->get());
    if (const auto* number = value.as_floating_point()) return lab::numberText(number->get());
    refuse(value, "'" + std::string(key) + "' must be a text, a number, true or false, or a list of texts or numbers");
    return {};
  }

  const std::filesystem::path& path_;
  ExperimentFile result_;
  std::optional<Error> wrong_;
};

}  // namespace

Result<ExperimentFile> readExperiment(const std::filesystem::path& path) { return Reader(path).read(); }

}  // namespace foreland::apps
