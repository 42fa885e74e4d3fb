// `foreland fly --viewers N`: flies many viewers from one process, one thread each, and reports on them together. They
// draw 20 frames a second instead of 60, since nobody looks at them.
#pragma once

#include <cstddef>

#include "apps/fly/fly_options.h"
#include "client/fly/player.h"

namespace foreland::apps {

// The exit code: 0 if every viewer has flown to the end of its flight, 2 otherwise. Prints the report.
int flyMany(const FlyOptions& o, client::PlayerOptions options);

}  // namespace foreland::apps
