// What a viewer asks of what is seen, while it is answered slice by slice: a slice looks at so much of the scene that
// it takes a few milliseconds, whatever is asked. One owner (Requests).
#pragma once

#include <cstdint>
#include <optional>

#include "base/bytes.h"
#include "proto/message/sight_message.h"
#include "server/sight/sight_supply.h"
#include "server/sight/viewshed.h"

namespace foreland::server {

// What a slice has come to.
struct SightSlice {
  std::optional<Bytes> message;
  bool is_whole = false;      // nothing is left to do
  bool is_preparing = false;  // the scene for it is being made
};

// Pairs of points: one reply, once all are known.
class SightWork {
 public:
  explicit SightWork(const proto::SightRequest& request) : request_(request) { reply_.id = request.id; }
  uint32_t id() const { return request_.id; }
  size_t bytes() const;
  SightSlice proceed(SightSupply& supply);

 private:
  void ask(const SightScene& scene, size_t pair, uint64_t& work);

  proto::SightRequest request_;
  proto::SightReply reply_;
  std::optional<SightTime> time_;
};

// A viewshed: a reply for each slice.
class ViewshedWork {
 public:
  explicit ViewshedWork(const proto::ViewshedRequest& request) : request_(request) {}
  uint32_t id() const { return request_.id; }
  size_t bytes() const { return sizeof(*this) + sizeof(Viewshed); }
  SightSlice proceed(SightSupply& supply);

 private:
  Status begin(std::shared_ptr<const SightScene> scene);
  SightSlice tell();
  SightSlice refuse(const Error& error) const;

  proto::ViewshedRequest request_;
  std::optional<Viewshed> viewshed_;  // once it has begun
  uint32_t told_ = 0;                 // cells
};

}  // namespace foreland::server
