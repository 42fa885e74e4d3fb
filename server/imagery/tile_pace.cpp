#include "server/imagery/tile_pace.h"

#include <algorithm>
#include <utility>

namespace foreland::server {

namespace {

constexpr double kMin = 10e3, kMax = 50e6;  // bytes a second
constexpr size_t kMaxUnderWay = 64;
constexpr double kDrift_us = 100;      // that a delay may grow from keyframe to keyframe because clocks differ
constexpr double kAllowed_us = 20e3;   // that a keyframe may queue, and as long as half a tile takes
constexpr double kHalfTile = 8e3;      // bytes
constexpr double kMaxShares = 3;       // of an interval, that may be under way
constexpr double kMaxLatency_s = 0.3;  // of a round trip; what takes longer was transmitted so slowly
// Less than so much, or what is sent sooner, tells no more than that the link is not slower: it takes its time for
// other reasons.
constexpr double kMinBatch = 8e3;                                  // bytes
constexpr double kShortest_s = 0.02;                               // seconds
constexpr double kUsed = 0.9;                                      // of the link, by keyframes and tiles together
constexpr double kStep = 0.03, kMaxDown = 0.25, kFirstStep = 0.3;  // of the rate, from keyframe to keyframe

}  // namespace

void TilePace::keyframeArrived(uint32_t index, Time arrived_client, Duration round_trip) {
  const bool is_next = !under_way_.empty() && under_way_.front().index == index;
  while (!under_way_.empty() && under_way_.front().index < index) under_way_.pop_front();
  if (under_way_.empty() || under_way_.front().index != index) return;
  const Sent keyframe = under_way_.front();
  under_way_.pop_front();
  delivered_ = keyframe.bytes;
  if (!std::exchange(is_measured_, true) && is_next) {
    const double least = keyframe.own_bytes / std::max(round_trip.toSeconds(), 1e-3);
    const double most = keyframe.own_bytes / std::max(round_trip.toSeconds() - kMaxLatency_s, 1e-3);
    bytes_per_second_ = std::clamp(std::clamp(bytes_per_second_, least, std::max(least, most)), kMin, kMax);
  }
  const auto delay_us = static_cast<double>(arrived_client.us - keyframe.at.us);
  min_us_ = min_us_ ? std::min(*min_us_ + kDrift_us, delay_us) : delay_us;
  const double queued_us = delay_us - *min_us_;
  const double allowed_us = kAllowed_us + 1e6 * kHalfTile / bytes_per_second_;
  was_full_ = was_full_ || queued_us > 2 * allowed_us;
  const double missing = (allowed_us - queued_us) / allowed_us;  // of what may be queued; below 0: too much is
  // Where tiles were few the link was not tried.
  if (missing > 0 && !keyframe.is_tried) return;
  const double step = was_full_ ? std::max(kStep * missing, -kMaxDown) : kFirstStep;
  bytes_per_second_ = std::clamp(bytes_per_second_ * (1 + step), kMin, kMax);
}

void TilePace::given(Time now) { batch_at_ = now; }

void TilePace::drained(Time now) {
  if (!batch_at_) return;
  const double took_s = (now - *std::exchange(batch_at_, std::nullopt)).toSeconds();
  const double rate = batch_bytes_ / std::max(took_s, kShortest_s);
  if (batch_bytes_ >= kMinBatch && took_s > kShortest_s)
    link_ = rate;
  else if (link_)
    link_ = std::max(*link_, rate);
}

void TilePace::keyframeSent(uint32_t index, size_t bytes, Time now, double interval_s, uint32_t max_bytes_per_second) {
  batch_at_.reset(), batch_bytes_ = static_cast<double>(bytes);
  under_way_.push_back({index, now, static_cast<double>(bytes), sent_, credit_ <= 0});
  if (under_way_.size() > kMaxUnderWay) under_way_.pop_front();
  double rate = bytes_per_second_;
  if (max_bytes_per_second > 0) rate = std::min(rate, 0.5 * max_bytes_per_second);
  interval_s = std::clamp(interval_s, 0.0, 1.0);
  double share = rate * interval_s;
  if (link_) share = std::clamp(kUsed * *link_ * interval_s - static_cast<double>(bytes), kMin * interval_s, share);
  // What was not used does not add up: it would be a burst.
  credit_ = std::min(credit_ + share, share);
  // The link has not even transmitted what it was given before.
  if (sent_ - delivered_ > (is_measured_ ? kMaxShares * share : 0)) credit_ = std::min(credit_, 0.0);
}

void TilePace::sent(size_t bytes) {
  credit_ -= static_cast<double>(bytes);
  sent_ += static_cast<double>(bytes);
  batch_bytes_ += static_cast<double>(bytes);
}

}  // namespace foreland::server
