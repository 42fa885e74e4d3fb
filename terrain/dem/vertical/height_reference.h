// What the heights of an input count from: as the user says, else as the input's reference system does. One owner, one
// thread at a time.
#pragma once

#include <map>
#include <memory>
#include <optional>
#include <string>

#include "base/result.h"
#include "proto/space/vertical.h"
#include "terrain/geoid/geoid.h"

namespace foreland::terrain {

struct HeightReference {
  proto::ZeroSurface zero_surface = proto::ZeroSurface::kUnstated;
  std::string name;  // two references of one name are the same
  // Of a geoid whose undulations are known; else `why_unknown` says why not.
  std::shared_ptr<const Geoid> geoid;
  std::string why_unknown;

  bool isStated() const { return zero_surface != proto::ZeroSurface::kUnstated; }
};

inline constexpr const char* kEllipsoidName = "ellipsoid";
inline constexpr const char* kAsTheFileSays = "file";

// Whether a choice is known by its name, and no file.
bool isNamedDatum(const std::string& choice);
// The choice that a reference of this name comes of; empty if no choice by name does.
std::string choiceNamed(const std::string& reference);

class HeightReferences {
 public:
  // By --vertical: ellipsoid, egm96, egm2008 or a grid's file. An Error: the grid is not there, or cannot be read.
  Result<HeightReference> chosen(const std::string& choice);
  // By a reference system as WKT, for places in `box`; unstated if it says nothing of heights.
  HeightReference statedBy(const std::string& wkt, const EarthBox& box);

 private:
  std::map<std::string, HeightReference> known_;  // each grid is opened once
};

}  // namespace foreland::terrain
