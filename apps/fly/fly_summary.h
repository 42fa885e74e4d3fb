// What `foreland fly` and `foreland replay` tell a person, in place of the report's keys (fly_report.h). Any thread.
#pragma once

#include "apps/fly/fly_report.h"
#include "apps/report/summary.h"

namespace foreland::apps {

// What was asked for beside what came; what is not well, and what to do about it.
Summary summaryFor(const FlySummary& flight);

}  // namespace foreland::apps
