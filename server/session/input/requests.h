// What one viewer asks for beside its keyframes, tours, heights of the ground and what is seen, until it is answered,
// in order. One owner (a session). Bounded. One tour and one viewshed wait at most, since they take long: who asks for
// another one does not want the first any more. What is seen is answered in slices, a viewshed by a message for each.
#pragma once

#include <deque>
#include <variant>

#include "base/bytes.h"
#include "base/result.h"
#include "base/time.h"
#include "proto/message/message.h"
#include "server/session/input/sight_work.h"
#include "server/view/tour_plans.h"
#include "terrain/store/scene.h"

namespace foreland::server {

// What replies are made of, and when.
struct Answering {
  const terrain::Scene& scene;
  SightSupply& sight;
  TourPlans& tours;
  Time now;
};

class Requests {
 public:
  static constexpr size_t kMax = 16;

  // An Error if there is no such tour over the scene, or if too many requests wait. A tour or a viewshed takes the
  // place of one that waits, behind all else.
  Status add(const proto::TourRequest& request, const terrain::Scene& scene);
  Status add(const proto::GroundRequest& request);
  Status add(const proto::SightRequest& request);
  Status add(const proto::ViewshedRequest& request);
  // Forgets a request, if it waits.
  void cancel(const proto::RequestCancel& request);
  bool empty() const { return waiting_.empty(); }
  // That waiting requests take.
  size_t bytes() const;

  // How long the reply to the oldest may take, other viewers' keyframes first: a tour takes a worker longer than
  // several of these, so those who come together would stop all others. There must be one.
  Duration patience() const;

  // The reply to the oldest, or the next part of it; nothing if that takes another call. Once it is whole the request
  // is removed. Cost: some 0.05 s for a tour of minutes, O(positions) for heights, a few milliseconds for what is seen.
  SightSlice answer(const Answering& with);

 private:
  Status checkRoom() const;
  template <class Request>
  void forget();

  std::deque<std::variant<proto::TourRequest, proto::GroundRequest, SightWork, ViewshedWork>> waiting_;
};

}  // namespace foreland::server
