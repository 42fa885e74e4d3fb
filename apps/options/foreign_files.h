// What programs that read foreign files share: the option that lets these name files elsewhere, and the walls around
// the process (terrain/fence).
#pragma once

#include <CLI/CLI.hpp>
#include <cstdio>
#include <filesystem>
#include <string>
#include <vector>

#include "apps/options/options.h"
#include "terrain/fence/confine.h"
#include "terrain/fence/file_fence.h"

namespace foreland::apps {

struct ForeignFiles {
  std::vector<std::filesystem::path> allowed;
  bool is_verbose = false;
};

inline CLI::Option* addAllowedFolders(CLI::App& app, ForeignFiles& files) {
  return app
      .add_option("--allow-files-from", files.allowed,
                  "a folder that inputs may name files of, beside their own folders and what lies below these; by "
                  "default an input that names others is refused")
      ->type_name(apps::folder("DIR"))
      ->allow_extra_args(false);
}

inline void addForeignFiles(CLI::App& app, ForeignFiles& files) {
  addAllowedFolders(app, files);
  app.add_flag("--verbose", files.is_verbose, "say also what this kernel cannot do to confine this program");
}

// For the rest of the program. To be called before threads are started.
inline void confineTo(const ForeignFiles& files, const std::vector<std::filesystem::path>& inputs,
                      const std::vector<std::filesystem::path>& outputs) {
  const terrain::FileFence fence(inputs, files.allowed);
  terrain::Confinement confinement{fence.folders(), {}};
  confinement.read.insert(confinement.read.end(), fence.files().begin(), fence.files().end());
  for (const std::filesystem::path& output : outputs)
    if (!output.empty()) confinement.write.push_back(std::filesystem::absolute(output).parent_path());
  for (const std::string& missing : terrain::confine(confinement))
    if (files.is_verbose) std::fprintf(stderr, "note: %s\n", missing.c_str());
}

}  // namespace foreland::apps
