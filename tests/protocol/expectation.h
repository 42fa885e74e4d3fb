// What a viewer must hold at a keyframe, from refinement from scratch and the scene's own records: nothing of what was
// sent. Pure; a refinement each.
#pragma once

#include <string>
#include <vector>

#include "proto/codec/section_codec.h"
#include "proto/message/message.h"
#include "server/section/hierarchy.h"

namespace foreland::test {

proto::HeldSections emptySections(const server::Hierarchy& hierarchy);

// The sections of a keyframe's view.
proto::HeldSections sectionsOf(const server::Hierarchy& hierarchy, const proto::KeyframeHeader& keyframe);

// The line of NAME.expected (README.md); `before` are the sections that the viewer held.
std::string expectedLine(const server::Hierarchy& hierarchy, const proto::KeyframeHeader& keyframe,
                         const proto::HeldSections& before);

}  // namespace foreland::test
