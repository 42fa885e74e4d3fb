// The grids of a globe about the places where viewers are near the ground: made when a viewer comes there, by a thread
// of its own, or, in virtual time, by who asks; shared by all who are there, and kept until there is no room for
// another. A place is a square of a face; an eye goes on with the grid that it has until it is far from its middle,
// and while the next one is made.
//
// Any thread. Memory: kMost grids of 13 MB, and 60 MB while one is made.
#pragma once

#include <cstdint>
#include <memory>
#include <mutex>
#include <optional>
#include <thread>
#include <vector>

#include "server/occlusion/horizon/horizon_grid.h"

namespace foreland::server {

class GlobeGrids {
 public:
  enum class Building : uint8_t { kByTheCaller, kOnAThread };
  static constexpr size_t kMost = 8;

  // The scene is a globe whose ground does not move; `hierarchy` must outlive it.
  GlobeGrids(const Hierarchy& hierarchy, Building building);
  // Stops what is being made, and joins the thread.
  ~GlobeGrids() = default;
  GlobeGrids(const GlobeGrids&) = delete;
  GlobeGrids& operator=(const GlobeGrids&) = delete;

  using Grid = std::shared_ptr<const HorizonGrid>;
  // For an eye, of the scene frame, that has had `held`, which may be null. Null: there is none, or not yet; so it is
  // for eyes that are so high that ridges hide little, where viewers in other places hold all that there may be, and
  // while memory lacks for one.
  Grid about(const glm::dvec3& eye, const Grid& held);

  size_t bytes() const;

 private:
  struct Place {
    uint32_t x = 0, y = 0;  // of the square, in sides
    bool operator==(const Place&) const = default;
  };
  struct Entry {
    Place place;
    Grid grid;
    uint64_t asked = 0;  // when it was last asked for: a number that grows
  };

  std::optional<Place> placeOf(const glm::dvec3& eye) const;
  LocalPlane planeAt(const Place& place) const;
  Grid find(const Place& place);
  bool makeRoom();
  void make(const Place& place, const std::stop_token& stop);

  const Hierarchy& hierarchy_;
  const Building building_;
  double reach_m_;
  uint32_t side_log2_;  // of a place, lattice steps
  // Protects what follows; held for some instructions, and to start the thread.
  mutable std::mutex mutex_;
  std::vector<Entry> entries_;
  uint64_t asked_ = 0;
  bool is_making_ = false;
  std::jthread thread_;  // last: it uses the members above
};

}  // namespace foreland::server
