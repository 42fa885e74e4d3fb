#include "server/sight/sight_supply.h"

#include <pthread.h>
#include <sys/resource.h>

#include <new>
#include <utility>

namespace foreland::server {

namespace {

// Of the processors only what keyframes leave.
constexpr int kNice = 10;

}  // namespace

SightSupply::SightSupply(const Hierarchy& hierarchy, Building building, SightOptions options)
    : hierarchy_(hierarchy), building_(building), options_(options) {
  if (options_.max_bytes > 0) return;
  has_begun_ = true;
  made_ = Error{ErrorCode::kUnsupported, "this server answers no questions of what is seen (--sight-memory-mib 0)"};
}

Result<std::shared_ptr<const SightScene>> SightSupply::ask() {
  {
    const std::lock_guard lock(mutex_);
    if (made_) return *made_;
    if (std::exchange(has_begun_, true)) return std::shared_ptr<const SightScene>();
  }
  if (building_ == Building::kByTheCaller) {
    make();
    return *made_;
  }
  thread_ = std::jthread([this] {
    ::pthread_setname_np(::pthread_self(), "sight");
    ::setpriority(PRIO_PROCESS, 0, kNice);  // of this thread, on Linux
    make();
  });
  return std::shared_ptr<const SightScene>();
}

void SightSupply::make() {
  Result<std::shared_ptr<const SightScene>> made =
      Error{ErrorCode::kLimit, "there is no memory for questions of what is seen"};
  try {
    made = SightScene::create(hierarchy_, options_);
  } catch (const std::bad_alloc&) {}
  const std::lock_guard lock(mutex_);
  made_ = std::move(made);
}

}  // namespace foreland::server
