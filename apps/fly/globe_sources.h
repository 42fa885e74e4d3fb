// The files that a globe was made of, to be flown against. Main thread, before others are started.
#pragma once

#include <string>
#include <vector>

#include "apps/options/foreign_files.h"
#include "base/result.h"
#include "oracle/globe/source_oracle.h"
#include "terrain/store/scene.h"

namespace foreland::apps {

// Reads the files in a confined child, as far as each alone makes the ground. An Error: the scene is no globe, a file
// that cannot be read or that the scene does not name, an input that is not given.
Result<oracle::SourceOracle> sourceOracle(const terrain::Scene& scene, const std::vector<std::string>& sources,
                                          const ForeignFiles& foreign);

}  // namespace foreland::apps
