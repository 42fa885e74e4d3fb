// A link that is a program of the user's, of both ways and of any number of viewers. One owner, a run's.
#pragma once

#include "lab/external/asked_program.h"
#include "sim/link_models.h"

namespace foreland::lab {

// Links whose messages `program`, which outlives them, carries. After a failure they take no time.
sim::LinkPair toldLinks(AskedProgram& program);

}  // namespace foreland::lab
