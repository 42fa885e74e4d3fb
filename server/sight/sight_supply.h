// The one SightScene that all viewers of a server share, made when somebody first asks: on a thread of its own, or, in
// virtual time, by who asks. Any thread.
#pragma once

#include <cstdint>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <thread>

#include "base/result.h"
#include "server/sight/sight_scene.h"

namespace foreland::server {

class SightSupply {
 public:
  enum class Building : uint8_t { kByTheCaller, kOnAThread };

  // `hierarchy` must outlive it. Of 0 bytes it supplies nothing.
  explicit SightSupply(const Hierarchy& hierarchy, Building building = Building::kByTheCaller,
                       SightOptions options = {});
  // Joins the thread, which cannot be stopped: it ends with the scene.
  ~SightSupply() = default;
  SightSupply(const SightSupply&) = delete;
  SightSupply& operator=(const SightSupply&) = delete;

  // Null while it is being made, which the first call begins; an Error if it could not be made.
  Result<std::shared_ptr<const SightScene>> ask();

 private:
  void make();

  const Hierarchy& hierarchy_;
  const Building building_;
  const SightOptions options_;
  std::mutex mutex_;  // protects what follows but the thread; held for a few instructions
  bool has_begun_ = false;
  std::optional<Result<std::shared_ptr<const SightScene>>> made_;
  std::jthread thread_;  // last: it uses the members above; of who began
};

}  // namespace foreland::server
