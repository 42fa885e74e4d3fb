// The ground at other times on command lines: foreland build takes it, and so does foreland plan, whose words foreland
// block and foreland merge read again. Opens the ground at all dates. Main thread.
#pragma once

#include <CLI/CLI.hpp>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "apps/build/elevation_options.h"
#include "base/result.h"
#include "proto/section/epochs.h"
#include "terrain/elevation_source.h"
#include "terrain/epochs/read_epoch.h"
#include "terrain/objects/placed_objects.h"

namespace foreland::apps {

struct EpochArguments {
  std::vector<std::string> epochs;  // DATE=FILE
  proto::EpochBlend blend = proto::EpochBlend::kLinear;
};

// The options; `arguments` must live until the command line is parsed.
void describeEpochs(CLI::App& app, EpochArguments& arguments);

// After parsing: from here on what follows a date is the name of a file.
void takeVerticals(EpochArguments& arguments, terrain::OpenOptions& open);

// All files that the options name, for reading. Some may not be there.
std::vector<std::filesystem::path> filesOf(const EpochArguments& arguments);

// The dates alone: their epochs have no sources. An Error shows the form.
Result<std::vector<terrain::EpochRequest>> parseEpochs(const EpochArguments& arguments);

// Epochs at which the ground stays as it is, for the poses of the objects.
Result<std::vector<terrain::EpochRequest>> epochsOfPoses(const std::vector<terrain::ObjectRequest>& objects);

struct OpenedGround {
  std::unique_ptr<terrain::ElevationSource> source;
  std::vector<std::unique_ptr<terrain::ElevationSource>> of_epochs;
  std::vector<terrain::EpochRequest> epochs;  // with these
};
// Opens elevation; of ground that changes in time, which is what has epochs or `poses`, on a lattice that is fine
// everywhere. Epochs are those of the arguments, without their files, or if there are none `poses`.
Result<OpenedGround> openGround(const ElevationArguments& elevation, const EpochArguments& arguments,
                                std::vector<terrain::EpochRequest> poses);
// Opens the files of the epochs, too. Their heights count from what the scene's do, and lie on its lattice.
Status openEpochs(const ElevationArguments& elevation, const EpochArguments& arguments, OpenedGround& ground);

}  // namespace foreland::apps
