#include "apps/blocks/plan_file.h"

#include <algorithm>
#include <array>
#include <cstring>
#include <fstream>
#include <nlohmann/json.hpp>
#include <optional>
#include <utility>

#include "terrain/dem/open.h"
#include "terrain/pipeline/void_fill.h"
#include "terrain/store/file/checksum.h"
#include "terrain/store/file/new_file.h"

namespace foreland::apps {

namespace {

using Json = nlohmann::ordered_json;

constexpr int kPlanVersion = 1;

// What blocks are made of.
std::vector<std::filesystem::path> groundFilesOf(const PlanArguments& arguments) {
  std::vector<std::filesystem::path> files = filesOf(arguments.elevation);
  const std::vector<std::filesystem::path> of_epochs = filesOf(arguments.epochs);
  files.insert(files.end(), of_epochs.begin(), of_epochs.end());
  return files;
}

std::string hex(uint64_t value) {
  std::array<char, 17> text{};
  std::snprintf(text.data(), text.size(), "%016llx", static_cast<unsigned long long>(value));
  return text.data();
}

Result<Json> describeSource(const std::filesystem::path& file) {
  std::ifstream in(file, std::ios::binary);
  if (!in) return Error{ErrorCode::kIo, file.string() + ": cannot be read"};
  Bytes chunk(1 << 20);
  uint64_t hash = 0, bytes = 0;
  while (in.read(reinterpret_cast<char*>(chunk.data()), static_cast<std::streamsize>(chunk.size())), in.gcount() > 0) {
    hash = terrain::xxh64(ByteSpan(chunk).first(static_cast<size_t>(in.gcount())), hash);
    bytes += static_cast<uint64_t>(in.gcount());
  }
  return Json{{"file", file.string()}, {"bytes", bytes}, {"xxh64", hex(hash)}};
}

// About what a job of one block holds, beside its programs: heights, records and errors with their halo, and as many
// rows as are read at a time; in time also a walk's heights, what each epoch says, and how far it is from the first.
uint64_t memoryOfBlock(const terrain::BlockPlan& plan) {
  const uint64_t side = (1ull << plan.block_log2) + 2 * terrain::Blocks::kHalo,
                 in_time = plan.epochs.empty() ? 0 : 24 + 8 * plan.epochs.size();
  return ((side * side * (40 + in_time) + uint64_t{128} * 4 * plan.shape.samples_x) >> 20) + 192;
}

Error damaged(const std::filesystem::path& path, const std::string& what) {
  return {ErrorCode::kMalformed,
          path.string() + ": no plan of this version (" + what + "); make it with foreland plan"};
}

Result<Json> readJson(const std::filesystem::path& path) {
  std::ifstream in(path);
  if (!in) return Error{ErrorCode::kIo, path.string() + ": cannot be read; make it with foreland plan"};
  Json json = Json::parse(in, nullptr, false);
  if (json.is_discarded()) return damaged(path, "not JSON");
  if (json.value("foreland_plan", 0) != kPlanVersion) return damaged(path, "foreland_plan is not 1");
  return json;
}

Status parseWords(std::vector<std::string> words, PlanArguments& arguments) {
  CLI::App app;
  describePlanned(app, arguments);
  std::reverse(words.begin(), words.end());
  try {
    app.parse(words);
  } catch (const CLI::ParseError& error) { return Error{ErrorCode::kMalformed, error.what()}; }
  takeVerticals(arguments.elevation);
  takeVerticals(arguments.epochs, arguments.elevation.open);
  if (Status s = takeInsets(arguments.elevation); !s.ok()) return s;
  arguments.elevation.open.allowed_folders = arguments.foreign.allowed;
  return {};
}

Error changed(const std::filesystem::path& path, const std::string& file, const std::string& now) {
  return {ErrorCode::kInvalidArgument,
          file + ": " + now + ", not what " + path.string() + " was made of; make the plan again with foreland plan"};
}

Status checkSources(const std::filesystem::path& path, const Json& json) {
  for (const Json& source : json.at("sources")) {
    const std::string file = source.at("file");
    std::error_code error;
    if (const uint64_t bytes = std::filesystem::file_size(file, error); error || bytes != source.at("bytes"))
      return changed(path, file, error ? error.message() : std::to_string(bytes) + " bytes");
  }
  return {};
}

// Of a scene that changes in time.
std::vector<terrain::EpochRequest> datesOf(const Json& json) {
  std::vector<terrain::EpochRequest> epochs;
  if (const auto dates = json.find("epochs"); dates != json.end())
    for (const Json& epoch : *dates)
      epochs.push_back({Time{epoch.at("time_us").get<int64_t>()}, epoch.at("date").get<std::string>(), nullptr});
  return epochs;
}

// What voids are filled with; null if the plan has none.
Result<std::shared_ptr<const terrain::VoidFill>> openVoids(const std::filesystem::path& path, const Json& json) {
  const auto voids = json.find("voids");
  if (voids == json.end()) return std::shared_ptr<const terrain::VoidFill>();
  const auto file = path.parent_path() / std::filesystem::path(voids->at("file").get<std::string>()).filename();
  auto fill = terrain::VoidFill::open(file, json.at("samples").at(0), json.at("samples").at(1));
  if (!fill) return fill.error();
  if (hex(fill->id()) != voids->at("content").get<std::string>())
    return Error{ErrorCode::kInvalidArgument, file.string() + ": not what voids are filled with by " + path.string() +
                                                  "; make the plan again with foreland plan"};
  return std::make_shared<const terrain::VoidFill>(std::move(fill).value());
}

// Nothing else notices when a picture or a model is another one, so all of it is looked at.
Status checkAdditions(const std::filesystem::path& path, const Json& json) {
  for (const Json& wanted : json.at("additions")) {
    const std::string file = wanted.at("file");
    const auto found = describeSource(file);
    if (!found) return found.error();
    if (*found != wanted) return changed(path, file, "another content");
  }
  return {};
}

Status describeAll(const std::vector<std::filesystem::path>& files, Json& list) {
  list = Json::array();
  for (const std::filesystem::path& file : files) {
    auto source = describeSource(file);
    if (!source) return source.error();
    list.push_back(std::move(*source));
  }
  return {};
}

Status fill(const Json& json, terrain::BlockPlan& plan) {
  if (const auto voids = json.find("voids"); voids != json.end()) {
    plan.voids_filled = voids->at("samples");
    plan.voids_note = voids->at("note");
  }
  plan.range = {json.at("lowest"), json.at("highest")};
  plan.quantum_note = json.at("quantum_note");
  for (const Json& block : json.at("blocks"))
    plan.ids.push_back(std::stoull(block.at("id").get<std::string>(), nullptr, 16));
  return {};
}

Result<OpenedPlan> open(const std::filesystem::path& path, PlanUse use,
                        const std::vector<std::filesystem::path>& outputs) {
  const auto json = readJson(path);
  if (!json) return json.error();
  PlanArguments arguments;
  if (Status s = parseWords(json->at("arguments").get<std::vector<std::string>>(), arguments); !s.ok())
    return damaged(path, s.error().message);
  if (Status s = checkSources(path, *json); !s.ok()) return s.error();
  const bool is_merge = use == PlanUse::kMerge;
  if (is_merge)
    if (Status s = checkAdditions(path, *json); !s.ok()) return s.error();
  // Foreign files may not read in the plan's folder, so this is opened before they are. A merge reads no heights.
  std::shared_ptr<const terrain::VoidFill> voids;
  if (!is_merge) {
    auto found = openVoids(path, *json);
    if (!found) return found.error();
    voids = std::move(found).value();
  }
  confineTo(arguments.foreign, is_merge ? filesOf(arguments) : groundFilesOf(arguments), outputs);
  OpenedPlan opened;
  auto input = openGround(arguments.elevation, arguments.epochs, datesOf(*json));
  if (!input) return input.error();
  opened.input = std::move(input).value();
  if (!is_merge)
    if (Status s = openEpochs(arguments.elevation, arguments.epochs, opened.input); !s.ok()) return s.error();
  const uint32_t block_log2 = json->at("block_log2");
  if (block_log2 < terrain::Blocks::kLeastLog2 || block_log2 > 12) return damaged(path, "block_log2");
  auto plan = terrain::emptyPlan(opened.source(), json->at("height_quantum_m"), block_log2, arguments.epochs.blend);
  if (!plan) return plan.error();
  opened.plan = std::move(plan).value();
  opened.plan.epochs = terrain::datesOf(opened.input.epochs);
  if (Status s = fill(*json, opened.plan); !s.ok()) return s.error();
  const auto grid = proto::GridTopology::create(opened.plan.shape);
  if (opened.plan.ids.size() != terrain::Blocks{*grid, block_log2}.count() ||
      hex(opened.plan.id()) != json->at("id").get<std::string>())
    return Error{ErrorCode::kInvalidArgument,
                 path.string() + ": does not fit " + opened.source().info().title +
                     " as it is now, or was edited; make the plan again with foreland plan"};
  opened.plan.voids = std::move(voids);
  if (!is_merge) return opened;
  auto with = openAdditions(arguments.scene, opened.source().info(), arguments.foreign.allowed);
  if (!with) return with.error();
  opened.with = std::move(*with);
  return opened;
}

}  // namespace

void describePlanned(CLI::App& app, PlanArguments& arguments) {
  describeInputs(app, arguments.elevation);
  describeEpochs(app, arguments.epochs);
  describeAdditions(app, arguments.scene);
  addForeignFiles(app, arguments.foreign);
}

std::vector<std::string> plannedWords(const CLI::App& app) {
  PlanArguments ignored;
  CLI::App planned;
  describePlanned(planned, ignored);
  std::vector<std::string> words;
  for (const CLI::Option* option : planned.get_options()) {
    const std::string name = option->get_name();
    const CLI::Option* given = app.get_option_no_throw(name);
    if (given == nullptr || given->count() == 0 || name == "--help") continue;
    if (option->get_expected_max() == 0) {
      words.push_back(name);
      continue;
    }
    for (const std::string& value : given->results())
      words.push_back(option->get_positional() ? value : name + "=" + value);
  }
  return words;
}

Status writePlan(const std::filesystem::path& path, const std::vector<std::string>& words,
                 const PlanArguments& arguments, const terrain::BlockPlan& plan) {
  Json json{{"foreland_plan", kPlanVersion},
            {"id", hex(plan.id())},
            {"arguments", words},
            {"samples", {plan.shape.samples_x, plan.shape.samples_y}},
            {"block_log2", plan.block_log2},
            {"height_quantum_m", plan.frame.height_quantum_m},
            {"quantum_note", plan.quantum_note},
            {"lowest", plan.range.lowest},
            {"highest", plan.range.highest},
            {"memory_mib", memoryOfBlock(plan)},
            {"sources", Json::array()},
            {"additions", Json::array()}};
  if (plan.voids)
    json["voids"] = {{"file", plan.voids->path().filename().string()},
                     {"content", hex(plan.voids->id())},
                     {"samples", plan.voids_filled},
                     {"note", plan.voids_note}};
  for (const terrain::BlockEpoch& epoch : plan.epochs)
    json["epochs"].push_back({{"date", epoch.date}, {"time_us", epoch.time.us}});
  json["blocks"] = Json::array();
  if (Status s = describeAll(groundFilesOf(arguments), json["sources"]); !s.ok()) return s;
  if (Status s = describeAll(filesOf(arguments.scene), json["additions"]); !s.ok()) return s;
  for (const uint64_t id : plan.ids) json["blocks"].push_back({{"id", hex(id)}});
  const std::string text = json.dump(1) + "\n";
  auto file = terrain::NewFile::create(path, text.size());
  if (!file) return file.error();
  std::memcpy(file->data(), text.data(), text.size());
  return file->finish();
}

std::filesystem::path voidsBeside(const std::filesystem::path& plan) { return plan.string() + "."; }

std::vector<std::filesystem::path> filesOf(const PlanArguments& arguments) {
  std::vector<std::filesystem::path> files = groundFilesOf(arguments);
  const std::vector<std::filesystem::path> of_scene = filesOf(arguments.scene);
  files.insert(files.end(), of_scene.begin(), of_scene.end());
  return files;
}

Result<std::string> changedEpoch(const std::filesystem::path& plan) {
  try {
    const auto json = readJson(plan);
    if (!json) return json.error();
    PlanArguments arguments;
    if (Status s = parseWords(json->at("arguments").get<std::vector<std::string>>(), arguments); !s.ok())
      return s.error();
    for (const std::filesystem::path& file : filesOf(arguments.epochs)) {
      const auto found = describeSource(file);
      const Json& sources = json->at("sources");
      if (!found || std::ranges::find(sources, *found) == sources.end()) return file.string();
    }
    return std::string();
  } catch (const std::exception& error) { return damaged(plan, error.what()); }
}

Result<OpenedPlan> openPlan(const std::filesystem::path& path, PlanUse use,
                            const std::vector<std::filesystem::path>& outputs) {
  try {
    return open(path, use, outputs);
  } catch (const std::exception& error) { return damaged(path, error.what()); }
}

}  // namespace foreland::apps
