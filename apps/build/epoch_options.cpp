#include "apps/build/epoch_options.h"

#include <map>
#include <optional>
#include <set>
#include <utility>

#include "apps/options/date.h"
#include "apps/options/options.h"
#include "terrain/dem/on_lattice.h"
#include "terrain/dem/open.h"
#include "terrain/dem/vertical/height_reference.h"
#include "terrain/surface_store/mapped_surface.h"

namespace foreland::apps {

namespace {

std::filesystem::path fileOf(const std::string& epoch) { return epoch.substr(epoch.find('=') + 1); }

// As an option would say it; empty if nothing is stated, or no option can say it.
std::string verticalOfScene(const ElevationArguments& elevation, const terrain::ElevationInfo& info) {
  if (info.vertical.name.empty()) return {};
  if (elevation.open.scene_vertical) return *elevation.open.scene_vertical;
  const auto own = elevation.open.vertical_of.find(elevation.inputs.front().string());
  const auto choice = own != elevation.open.vertical_of.end() ? std::optional(own->second) : elevation.open.vertical;
  return choice && *choice != terrain::kAsTheFileSays ? *choice : terrain::choiceNamed(info.vertical.name);
}

}  // namespace

void describeEpochs(CLI::App& app, EpochArguments& arguments) {
  app.add_option("--epoch", arguments.epochs,
                 "the ground at a date: the scene changes in time from the first date to the last. The file may have "
                 "any grid and resolution; outside of it, and where it has no data, the ground is as at the date "
                 "before. The first is laid over INPUT")
      ->type_name(text("YYYY-MM-DD=FILE"))
      ->allow_extra_args(false);
  static const std::map<std::string, proto::EpochBlend> blends{{"linear", proto::EpochBlend::kLinear},
                                                               {"catmull-rom", proto::EpochBlend::kCatmullRom},
                                                               {"b-spline", proto::EpochBlend::kBSpline}};
  app.add_option_function<std::string>(
         "--epoch-blend", [&](const std::string& name) { arguments.blend = blends.at(name); },
         "how the ground moves from date to date: straight; catmull-rom: smoothly through every date's; b-spline: more "
         "smoothly, and past all but the first and the last")
      ->check(oneOf({"linear", "catmull-rom", "b-spline"}))
      ->default_str("linear");
}

void takeVerticals(EpochArguments& arguments, terrain::OpenOptions& open) {
  for (std::string& epoch : arguments.epochs) {
    const size_t split = epoch.find('=');
    if (split != std::string::npos && epoch.find(kVerticalOfOne) > split)
      epoch = epoch.substr(0, split + 1) + withoutVertical(epoch.substr(split + 1), open);
  }
}

std::vector<std::filesystem::path> filesOf(const EpochArguments& arguments) {
  std::vector<std::filesystem::path> files;
  for (const std::string& epoch : arguments.epochs) files.push_back(fileOf(epoch));
  return files;
}

Result<std::vector<terrain::EpochRequest>> parseEpochs(const EpochArguments& arguments) {
  std::vector<terrain::EpochRequest> epochs;
  for (const std::string& text : arguments.epochs) {
    const size_t split = text.find('=');
    const auto time = split == std::string::npos ? std::nullopt : parseDate(text.substr(0, split));
    if (!time || split + 1 == text.size())
      return Error{ErrorCode::kInvalidArgument, "--epoch " + text +
                                                    ": write YYYY-MM-DD=FILE, for example "
                                                    "2004-10-04=dome.tif"};
    epochs.push_back({*time, text.substr(0, split), nullptr});
  }
  return epochs;
}

Result<std::vector<terrain::EpochRequest>> epochsOfPoses(const std::vector<terrain::ObjectRequest>& objects) {
  std::set<Time> times;
  for (const terrain::ObjectRequest& object : objects) {
    const auto surface = terrain::MappedSurface::open(object.model);
    if (!surface.ok()) return surface.error();
    times.insert((*surface)->poseTimes().begin(), (*surface)->poseTimes().end());
  }
  std::vector<terrain::EpochRequest> epochs;
  for (const Time& time : times) epochs.push_back({time, dateText(time), nullptr});
  return epochs;
}

Result<OpenedGround> openGround(const ElevationArguments& elevation, const EpochArguments& arguments,
                                std::vector<terrain::EpochRequest> poses) {
  auto epochs = parseEpochs(arguments);
  if (!epochs) return epochs.error();
  OpenedGround ground;
  ground.epochs = epochs->empty() ? std::move(poses) : std::move(*epochs);
  terrain::OpenOptions open = elevation.open;
  // What changes in time has heights everywhere.
  if (!ground.epochs.empty()) open.lattice = terrain::LatticeChoice::kWhole;
  auto source = terrain::openElevation(elevation.inputs, open);
  if (!source) return source.error();
  ground.source = std::move(source).value();
  return ground;
}

Status openEpochs(const ElevationArguments& elevation, const EpochArguments& arguments, OpenedGround& ground) {
  const terrain::ElevationInfo& scene = ground.source->info();
  terrain::OpenOptions open = elevation.open;
  open.insets.clear();
  if (const std::string vertical = verticalOfScene(elevation, scene); !vertical.empty()) open.scene_vertical = vertical;
  for (size_t i = 0; i < arguments.epochs.size(); ++i) {
    const std::filesystem::path file = fileOf(arguments.epochs[i]);
    auto source = terrain::openElevation({file}, open);
    if (source.ok() && !terrain::isOnLatticeOf((*source)->info(), scene))
      source = terrain::openOnLattice(file, open, scene);
    if (!source) return Error{source.error().code, "epoch " + ground.epochs[i].date + ": " + source.error().message};
    ground.epochs[i].source = source->get();
    ground.of_epochs.push_back(std::move(source).value());
  }
  return {};
}

}  // namespace foreland::apps
