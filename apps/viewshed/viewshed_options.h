// What is seen from where: the options that `foreland viewshed` and `foreland render --viewshed` share. Main thread.
#pragma once

#include <CLI/CLI.hpp>
#include <optional>
#include <string>

#include "base/result.h"
#include "server/sight/viewshed.h"
#include "terrain/store/scene.h"

namespace foreland::apps {

struct ViewshedOptions {
  std::optional<std::string> from;  // LAT,LON,HEIGHT
  server::ViewshedQuestion question;
};

// --radius, --target and --refraction, in a group of their own.
void addViewshedOptions(CLI::App& app, ViewshedOptions& options, const std::string& group);

// The question with its observer; an Error that calls `from` by the option's name `option`.
Result<server::ViewshedQuestion> questionOf(const ViewshedOptions& options, const std::string& option,
                                            const terrain::Scene& scene);

}  // namespace foreland::apps
