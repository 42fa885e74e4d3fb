#include "server/net/metrics/processor_use.h"

#include <sched.h>
#include <sys/resource.h>

#include <algorithm>
#include <fstream>
#include <string>
#include <string_view>
#include <thread>

#include "base/smoothing.h"

namespace foreland::server {
namespace {

// Nobody is given fewer, whatever a file says, so shares of them stay finite.
constexpr double kMinProcessors = 0.01;

Duration timeOf(int who) {
  rusage usage{};
  if (::getrusage(who, &usage) != 0) return {};
  const auto microseconds = [](const timeval& t) { return int64_t{t.tv_sec} * 1'000'000 + t.tv_usec; };
  return {microseconds(usage.ru_utime) + microseconds(usage.ru_stime)};
}

// Of the calling thread, since it began: https://docs.kernel.org/scheduler/sched-stats.html
Duration ranOrWaited() {
  std::ifstream file("/proc/thread-self/schedstat");
  int64_t ran_ns = 0, waited_ns = 0;
  return file >> ran_ns >> waited_ns ? Duration{(ran_ns + waited_ns) / 1000} : timeOf(RUSAGE_THREAD);
}

// "50000 100000", or "max 100000".
std::optional<double> quotaOfVersion2(const std::filesystem::path& group) {
  std::ifstream file(group / "cpu.max");
  double quota_us = 0, period_us = 0;
  if (!(file >> quota_us >> period_us) || quota_us <= 0 || period_us <= 0) return std::nullopt;
  return quota_us / period_us;
}

std::optional<double> quotaOfVersion1(const std::filesystem::path& group) {
  std::ifstream quota(group / "cpu.cfs_quota_us"), period(group / "cpu.cfs_period_us");
  double quota_us = 0, period_us = 0;
  if (!(quota >> quota_us) || !(period >> period_us) || quota_us <= 0 || period_us <= 0) return std::nullopt;
  return quota_us / period_us;
}

// The lines of /proc/self/cgroup: "0::/a/b" of version 2, "4:cpu,cpuacct:/a/b" of version 1 (cgroups(7)).
std::optional<double> ownQuota() {
  std::ifstream file("/proc/self/cgroup");
  std::optional<double> least;
  for (std::string line; std::getline(file, line);) {
    const size_t first = line.find(':'), second = line.find(':', first + 1);
    if (second == std::string::npos) continue;
    const std::string controllers = "," + line.substr(first + 1, second - first - 1) + ",";
    const bool is_version_2 = controllers == ",,";
    if (!is_version_2 && controllers.find(",cpu,") == std::string::npos) continue;
    const auto quota = processorQuota(is_version_2 ? "/sys/fs/cgroup" : "/sys/fs/cgroup/cpu", line.substr(second + 1));
    if (quota) least = std::min(least.value_or(*quota), *quota);
  }
  return least;
}

double processors() {
  cpu_set_t set;
  CPU_ZERO(&set);
  const double own = ::sched_getaffinity(0, sizeof(set), &set) == 0 ? CPU_COUNT(&set)
                                                                    : std::max(1u, std::thread::hardware_concurrency());
  return std::max(kMinProcessors, std::min(own, ownQuota().value_or(own)));
}

}  // namespace

// A group's limit counts for all below it. In a container the path may be one that only its host knows; then the root
// is its own.
std::optional<double> processorQuota(const std::filesystem::path& groups, const std::filesystem::path& path) {
  std::optional<double> least;
  std::filesystem::path group = groups;
  const auto take = [&] {
    for (const auto& quota : {quotaOfVersion2(group), quotaOfVersion1(group)})
      if (quota) least = std::min(least.value_or(*quota), *quota);
  };
  take();
  for (const std::filesystem::path& name : path.relative_path()) {
    if (name == "..") break;
    group /= name;
    take();
  }
  return least;
}

void UsedShare::add(double share, Duration elapsed) {
  last_ = std::clamp(share, 0.0, 1.0);
  mean_ += weightOfNew(elapsed.toSeconds(), kMemory.toSeconds()) * (last_ - mean_);
}

void ProcessorUse::update(Time now) {
  const Duration thread = ranOrWaited(), process = timeOf(RUSAGE_SELF);
  if (updated_at_ && now > *updated_at_) {
    const Duration elapsed = now - *updated_at_;
    thread_.add((thread - thread_used_).toSeconds() / elapsed.toSeconds(), elapsed);
    process_.add((process - process_used_).toSeconds() / (elapsed.toSeconds() * processors()), elapsed);
  }
  updated_at_ = now;
  thread_used_ = thread, process_used_ = process;
}

}  // namespace foreland::server
