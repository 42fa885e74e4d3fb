// Whether a globe is as close to the files that it was made of as it states.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "apps/options/foreign_files.h"
#include "base/result.h"
#include "terrain/store/scene.h"

namespace foreland::apps {

// As verifySources() (verify_source.h), with all files at once, for where one alone counts depends on the others. They
// are taken in the order of the scene's inputs, and as above what the scene states of them. An Error: a file that
// cannot be read, or that the scene does not name, or an input that is not given.
Result<uint64_t> verifyGlobeSources(const terrain::Scene& scene, const std::vector<std::string>& sources,
                                    const ForeignFiles& foreign);

}  // namespace foreland::apps
