#include "terrain/dem/vertical/height_reference.h"

#include <utility>

#include "terrain/geoid/reference_heights.h"

namespace foreland::terrain {

bool isNamedDatum(const std::string& choice) {
  return choice == kEllipsoidName || choice == kAsTheFileSays || choice == "egm96" || choice == "egm2008";
}

std::string choiceNamed(const std::string& reference) {
  if (reference == "EGM96") return "egm96";
  if (reference == "EGM2008") return "egm2008";
  return reference == kEllipsoidName ? reference : "";
}

Result<HeightReference> HeightReferences::chosen(const std::string& choice) {
  if (choice == kEllipsoidName) return HeightReference{proto::ZeroSurface::kEllipsoid, kEllipsoidName, nullptr, {}};
  if (const auto at = known_.find(choice); at != known_.end()) return at->second;
  auto geoid = Geoid::open(choice);
  if (!geoid) return geoid.error();
  const HeightReference reference{proto::ZeroSurface::kGeoid, (*geoid)->name(), *geoid, {}};
  known_.emplace(choice, reference);
  return reference;
}

HeightReference HeightReferences::statedBy(const std::string& wkt, const EarthBox& box) {
  const HeightStatement stated = heightsOf(wkt);
  if (stated.kind == StatedHeights::kNone) return {};
  if (stated.kind == StatedHeights::kEllipsoid) return {proto::ZeroSurface::kEllipsoid, kEllipsoidName, nullptr, {}};
  if (const auto at = known_.find(stated.name); at != known_.end()) return at->second;
  auto geoid = Geoid::ofReferenceSystem(wkt, box);
  const HeightReference reference =
      geoid ? HeightReference{proto::ZeroSurface::kGeoid, (*geoid)->name(), *geoid, {}}
            : HeightReference{proto::ZeroSurface::kGeoid, stated.name, nullptr, geoid.error().message};
  known_.emplace(stated.name, reference);
  return reference;
}

}  // namespace foreland::terrain
