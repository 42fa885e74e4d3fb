// What a viewer must hold at a keyframe, from refinement from scratch and the scene's own records: nothing of what was
// sent. Pure; a refinement each.
#pragma once

#include <string>
#include <vector>

#include "proto/message.h"
#include "proto/section.h"
#include "server/section/hierarchy.h"

namespace foreland::test {

// The terrain's section and those of all objects.
struct Sections {
  proto::Section terrain;
  std::vector<proto::Section> objects;

  explicit Sections(const server::Hierarchy& hierarchy) : objects(hierarchy.objects().set.size()) {}  // empty
  uint32_t fingerprint() const;
};

// The sections of a keyframe's view.
Sections sectionsOf(const server::Hierarchy& hierarchy, const proto::KeyframeHeader& keyframe);

// The line of NAME.expected (README.md); `before` are the sections that the viewer held.
std::string expectedLine(const server::Hierarchy& hierarchy, const proto::KeyframeHeader& keyframe,
                         const Sections& before);

}  // namespace foreland::test
