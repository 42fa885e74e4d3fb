// The names of built-in tours as options take them (server/view/tour.h); whether a scene has one of them is seen later.
#pragma once

#include <CLI/CLI.hpp>
#include <string>
#include <vector>

#include "apps/options/options.h"

namespace foreland::apps {

// One of the tours, of `others`, or descent:LAT,LON.
inline CLI::Validator tourName(const std::vector<std::string>& others = {}) {
  std::vector<std::string> words{"survey", "canyon",       "spin",   "orbit",  "descent",
                                 "pole",   "antimeridian", "corner", "equator"};
  words.insert(words.end(), others.begin(), others.end());
  CLI::Validator validator = oneOf(words);
  return {[words](std::string& name) {
            if (name.starts_with("descent:")) return std::string();
            CLI::Validator one = oneOf(words);
            return one(name);
          },
          validator.get_description(), std::string(kOneOf)};
}

}  // namespace foreland::apps
