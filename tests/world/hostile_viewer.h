// A viewer that says anything at any time, straight to a session: requests of all kinds with extreme numbers, poses
// whose time stamps lie, paths, tours without end, false acknowledgements, sections that nobody holds, and valid
// messages with changed bytes. What it may not do is more than the session's limits. What it says follows from choices:
// those of a seed (base/rng.h), or a fuzzer's (tests/fuzz/fuzzed_choices.h).
#pragma once

#include <memory>
#include <string>

#include "server/session/session.h"

namespace foreland::test {

// `Choices` has what Rng has, and outlives the viewer.
template <class Choices>
class HostileViewer {
 public:
  HostileViewer(std::shared_ptr<const server::World> world, const server::SessionOptions& options, Choices& choices)
      : world_(std::move(world)), options_(options), choices_(choices) {
    connect();
  }

  // Says something, lets the session do what is due, and checks its limits.
  void act(Time now) {
    for (uint64_t i = choices_.below(4); i-- > 0;)
      if (!session_->receive(anything(now), now).ok()) connect();
    for (int i = 0; i < 4; ++i) {
      const auto due = session_->due();
      if (!due || due->release > now) break;
      const server::SessionStatistics before = session_->statistics();
      out_.clear();
      session_->step(now, scratch_, out_);
      session_->noteComputeTime(Duration::milliseconds(static_cast<int64_t>(choices_.below(30))));
      const server::SessionStatistics& after = session_->statistics();
      const bool made = after.keyframes > before.keyframes || after.replies > before.replies;
      if (unsent_ && made) complain("a keyframe or reply was made while one was unsent");
      if (out_.size() > 2) complain("more than two messages came of one step");
      unsent_ = unsent_ || made;
      if (session_->statistics().section_nodes > options_.max_section_nodes) complain("a section exceeds its limit");
    }
    if (unsent_ && choices_.below(3) > 0) {
      unsent_ = false;
      session_->onDrained(now);
    }
    if (session_->statistics().skipped_keyframes > 10'000)
      complain("more keyframes were skipped than there was time for");
    if (choices_.below(60) == 0) connect();
  }
  const std::string& report() const { return complaints_; }

 private:
  void complain(const std::string& what) { complaints_ += what + "\n"; }

  void connect() {
    session_ = std::make_unique<server::Session>(world_, options_);
    memory_ = {};
    unsent_ = false;
    if (choices_.below(20) > 0) (void)session_->receive(proto::encode(request()), Time{});
  }

  double anyNumber() {
    constexpr double kNumbers[] = {0, 1, -1, 1e-300, 1e8, -1e8, 1e300, 200, 0.5};
    return choices_.below(3) == 0 ? kNumbers[choices_.below(std::size(kNumbers))] : choices_.uniform(-5000, 5000);
  }
  int64_t anyTime(Time now) {
    constexpr int64_t kMax = int64_t{1} << 60;
    switch (choices_.below(8)) {
      case 0:
        return static_cast<int64_t>(choices_.next());
      case 1:
        return choices_.below(2) == 0 ? kMax : -kMax;
      case 2:
        return now.us + static_cast<int64_t>(choices_.below(1'000'000'000'000));
      default:
        return now.us - 500'000 + static_cast<int64_t>(choices_.below(600'000));
    }
  }
  proto::Pose anyPose() {
    const glm::dvec3 forward(choices_.uniform(-1, 1), choices_.uniform(-1, 1), choices_.uniform(-1, 0.5));
    return {{anyNumber(), anyNumber(), anyNumber()}, proto::lookAlong(glm::normalize(forward), {0, 0, 1})};
  }
  proto::ViewRequest request() {
    proto::ViewRequest r;
    r.lens = {choices_.uniform(0.017, 2.9), 1 + static_cast<uint32_t>(choices_.below(16384)),
              1 + static_cast<uint32_t>(choices_.below(16384))};
    r.tau_px = choices_.below(3) == 0 ? 0.01 : choices_.uniform(0.01, 1000);
    r.strategy = static_cast<proto::Strategy>(choices_.below(3));
    r.predictor = static_cast<proto::Predictor>(choices_.below(6));
    r.keyframe_interval = Duration::milliseconds(20 + static_cast<int64_t>(choices_.below(100)));
    r.max_triangles = choices_.below(3) == 0 ? static_cast<uint32_t>(choices_.next()) : 0;
    r.max_bytes_per_second = choices_.below(3) == 0 ? 1 + static_cast<uint32_t>(choices_.below(100'000)) : 0;
    return r;
  }
  proto::Path path(Time now) {
    proto::Path path{Time{anyTime(now)}, Duration{1000 + static_cast<int64_t>(choices_.below(60'000'000))}, {}};
    for (uint64_t i = 2 + choices_.below(40); i-- > 0;) path.poses.push_back(anyPose());
    return path;
  }

  Bytes valid(Time now) {
    switch (choices_.below(16)) {
      case 0:
        return proto::encode(request());
      case 1:
        return proto::encode(path(now));
      case 2:
        return proto::encode(
            proto::TourRequest{static_cast<uint32_t>(choices_.next()), "survey", choices_.uniform(1, 60)});
      case 3:
        return proto::encode(proto::GroundRequest{1, {{anyNumber(), anyNumber()}, {NAN, 1e308}}});
      case 12:
        return proto::encode(proto::SightRequest{
            2,
            {{choices_.uniform(-9, 99), choices_.uniform(-9, 99), 1}, {choices_.uniform(-1e6, 1e6), 3, 1e5}},
            choices_.below(2) == 0 ? proto::Above::kGround : proto::Above::kZeroSurface,
            choices_.uniform(0, 1),
            Time{anyTime(now) >> 2}});
      case 13:
        return proto::encode(proto::ViewshedRequest{3,
                                                    {choices_.uniform(-9, 99), choices_.uniform(-9, 99)},
                                                    2,
                                                    0,
                                                    choices_.uniform(1, 2000),
                                                    choices_.uniform(0.5, 60)});
      case 14:
        return proto::encode(proto::RequestCancel{static_cast<uint32_t>(choices_.below(5))});
      case 4:
        return proto::encode(proto::Resume{world_->hierarchy.scene().id(), 1 + static_cast<uint32_t>(choices_.below(9)),
                                           Time{anyTime(now)}, static_cast<uint32_t>(choices_.next()),
                                           Bytes(choices_.below(2000), static_cast<uint8_t>(choices_.next()))});
      default: {
        proto::PoseUpdate update{{Time{anyTime(now)}, anyPose()}, session_->keyframe().index, Time{anyTime(now)}};
        if (choices_.below(30) == 0) update.received_keyframe += static_cast<uint32_t>(choices_.below(3));
        // The encoder takes differences of times and positions, which must not overflow; times may be 2^60 at most.
        for (Time* time : {&update.pose.time, &update.received_at}) time->us >>= 2;
        const bool is_absolute = choices_.below(2) == 0 || !proto::isUsable(update.pose.pose);
        return is_absolute ? proto::encode(update) : proto::encode(update, memory_);
      }
    }
  }
  Bytes anything(Time now) {
    Bytes message = valid(now);
    if (choices_.below(6) > 0) return message;
    for (uint64_t i = choices_.below(4); i-- > 0 && !message.empty();)
      message[choices_.below(message.size())] = static_cast<uint8_t>(choices_.next());
    if (choices_.below(4) == 0) message.resize(choices_.below(message.size() + 1));
    return message;
  }

  std::shared_ptr<const server::World> world_;
  server::SessionOptions options_;
  Choices& choices_;
  std::unique_ptr<server::Session> session_;
  server::SessionScratch scratch_;
  std::vector<Bytes> out_;
  proto::PoseMemory memory_;
  bool unsent_ = false;
  std::string complaints_;
};

}  // namespace foreland::test
