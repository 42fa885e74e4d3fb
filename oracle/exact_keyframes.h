// What keyframes would have been, had their poses been known; the last few are kept.
#pragma once

#include <map>
#include <memory>
#include <mutex>
#include <utility>

#include "oracle/section_at.h"
#include "proto/message/message.h"

namespace foreland::oracle {

// A section that is computed when it is asked for, once, by whoever asks first; others wait for it. Any thread.
class ExactSection {
 public:
  explicit ExactSection(const SectionRequest& wanted) : wanted_(wanted) {}

  // `section_at` is the asking thread's.
  const std::shared_ptr<const client::KeyframeMesh>& mesh(const SectionAt& section_at) {
    std::call_once(is_computed_, [&] { mesh_ = section_at(wanted_); });
    return mesh_;
  }

 private:
  const SectionRequest wanted_;
  std::once_flag is_computed_;
  std::shared_ptr<const client::KeyframeMesh> mesh_;
};

// One owner.
class ExactKeyframes {
 public:
  // The section of the keyframe `header` for the true pose at its time, with the region that the keyframe has.
  std::shared_ptr<ExactSection> at(const proto::Pose& pose, const proto::Lens& lens,
                                   const proto::KeyframeHeader& header) {
    std::shared_ptr<ExactSection>& section = sections_[header.index];
    if (!section)
      section = std::make_shared<ExactSection>(SectionRequest{.pose = pose,
                                                              .lens = lens,
                                                              .tau_px = header.tau_px,
                                                              .region_radius_m = header.region_radius_m,
                                                              .region_angle_rad = header.region_angle_rad,
                                                              .scene_time = header.scene_time});
    const std::shared_ptr<ExactSection> result = section;
    while (sections_.size() > kKept) sections_.erase(sections_.begin());
    return result;
  }

 private:
  static constexpr size_t kKept = 3;
  std::map<uint32_t, std::shared_ptr<ExactSection>> sections_;
};

}  // namespace foreland::oracle
