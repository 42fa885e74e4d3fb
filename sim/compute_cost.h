// What a step of a session costs in processor time, computed from the work that it did, so that results do not depend
// on how busy the machine was. The prices are measured once by `foreland bench calibrate` and kept in a file; those
// that ship are of the machine that lab/README.md names. Value types; any thread.
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <span>
#include <string>

#include "base/result.h"
#include "base/time.h"
#include "server/session/session.h"

namespace foreland::sim {

// Work of one step, counted.
struct StepWork {
  uint64_t keyframes = 0;  // 0 or 1
  uint64_t tested = 0;     // nodes tested exactly by the adapter, and left as they were
  uint64_t swept = 0;      // entries of its frontier that were swept
  uint64_t changed = 0;    // nodes added and removed, their tests included
  uint64_t measured = 0;   // nodes of sections that were refined from scratch to be counted
  uint64_t bytes = 0;      // written
  uint64_t resumed = 0;    // nodes that a viewer who resumes presents, in its section or remembered
  // With occlusion: tests of blocks and segments of horizons that are built for them (server/occlusion), rays, and
  // queries of what solids of objects hide.
  uint64_t blocks = 0, segments = 0, rays = 0, queries = 0;

  // Of a step that has just been done; before it the session's statistics were `before`.
  static StepWork between(const server::SessionStatistics& before, const server::Session& session, uint64_t bytes);
  StepWork& operator+=(const StepWork& other);
  template <class Visit>
  void fields(const Visit& visit) const {
    visit("keyframes", keyframes);
    visit("tested", tested);
    visit("swept", swept);
    visit("changed", changed);
    visit("measured", measured);
    visit("bytes", bytes);
    visit("resumed", resumed);
    visit("blocks", blocks);
    visit("segments", segments);
    visit("rays", rays);
    visit("queries", queries);
  }
};

inline constexpr size_t kWorkKinds = 11;

// Nanoseconds for each, in the order of StepWork.
struct ComputePrices {
  std::string name = "default";  // what reports call them: of the file, where they are from one
  double keyframe = 156'000, tested = 150, swept = 5.1, changed = 55, measured = 38, byte = 92, resumed = 119;
  double block = 497, segment = 46'000, ray = 1000, query = 500;

  Duration of(const StepWork& work) const;
  // What each kind of the work takes, in nanoseconds.
  std::array<double, kWorkKinds> each(const StepWork& work) const;
  std::string toJson() const;
  template <class Visit>
  void fields(const Visit& visit) const {
    visitAll(*this, visit);
  }
  template <class Visit>
  void fields(const Visit& visit) {
    visitAll(*this, visit);
  }

 private:
  template <class Prices, class Visit>
  static void visitAll(Prices& p, const Visit& visit) {
    visit("ns_keyframe", p.keyframe);
    visit("ns_tested", p.tested);
    visit("ns_swept", p.swept);
    visit("ns_changed", p.changed);
    visit("ns_measured", p.measured);
    visit("ns_byte", p.byte);
    visit("ns_resumed", p.resumed);
    visit("ns_block", p.block);
    visit("ns_segment", p.segment);
    visit("ns_ray", p.ray);
    visit("ns_query", p.query);
  }
};

// Errors name the file and the price that is missing, no number, negative or not finite.
Result<ComputePrices> readPrices(const std::filesystem::path& path);

struct TimedWork {
  StepWork work;
  double seconds = 0;
  template <class Visit>
  void fields(const Visit& visit) const {
    work.fields(visit);
    visit("seconds", seconds);
  }
};
// The prices that explain the times best, in the sense of least squares of the relative errors, none below zero.
ComputePrices fitPrices(std::span<const TimedWork> steps);

using ComputeTime = std::function<Duration(const StepWork&)>;

}  // namespace foreland::sim
