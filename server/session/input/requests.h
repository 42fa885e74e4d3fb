// What one viewer asks for beside its keyframes, tours and heights of the ground, until it is answered, in order. One
// owner (a session). Bounded. One tour waits at most, since a tour takes up to a second: who asks for another one does
// not want the first any more.
#pragma once

#include <deque>
#include <variant>

#include "base/bytes.h"
#include "base/result.h"
#include "proto/message/message.h"
#include "terrain/store/scene.h"

namespace foreland::server {

class Requests {
 public:
  static constexpr size_t kMax = 16;

  // An Error if there is no such tour, or if too many requests wait. A tour takes the place of one that waits, behind
  // all else.
  Status add(const proto::TourRequest& request);
  Status add(const proto::GroundRequest& request);
  bool empty() const { return waiting_.empty(); }
  // That waiting requests take.
  size_t bytes() const;

  // Removes the oldest and returns the reply to it. Cost: up to a second for a tour, O(positions) for heights.
  Bytes answer(const terrain::Scene& scene);

 private:
  Status checkRoom() const;

  std::deque<std::variant<proto::TourRequest, proto::GroundRequest>> waiting_;
};

}  // namespace foreland::server
