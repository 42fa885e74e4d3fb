// What a viewer must hold at a keyframe, from refinement from scratch and the scene's own records: nothing of what was
// sent. Pure; a refinement each.
#pragma once

#include <string>

#include "proto/message.h"
#include "proto/section.h"
#include "server/section/hierarchy.h"

namespace foreland::test {

// The section of a keyframe's view.
proto::Section sectionOf(const server::Hierarchy& hierarchy, const proto::KeyframeHeader& keyframe);

// The line of NAME.expected (README.md); `before` is the section that the viewer held.
std::string expectedLine(const server::Hierarchy& hierarchy, const proto::KeyframeHeader& keyframe,
                         const proto::Section& before);

}  // namespace foreland::test
