#include "lab/cost.h"

namespace foreland::lab {

namespace {

using Json = nlohmann::ordered_json;

constexpr const char* kNeeded[] = {"asked_px",   "rms_px",
                                   "bytes",      "bytes_in_flight",
                                   "requests",   "requests_in_flight",
                                   "compute_ms", "compute_in_flight_ms"};

// An hour of flight, and the first views of the visits that it is made of.
double perHour(const Json& row, const char* all, const char* in_flight, double seconds, double visit_minutes) {
  const double flown = row[in_flight].get<double>(), first = row[all].get<double>() - flown;
  return flown * 3600 / seconds + first * 60 / visit_minutes;
}

ViewerHour hourOf(const Json& row, double seconds, const CostPrices& prices) {
  const auto rate = [&](const char* all, const char* in_flight) {
    return perHour(row, all, in_flight, seconds, prices.visit_minutes);
  };
  ViewerHour hour{.way = row["way"], .asked_px = row["asked_px"], .rms_px = row["rms_px"]};
  const bool is_ours = hour.way == "foreland";
  hour.mb = 1e-6 * rate("bytes", "bytes_in_flight");
  hour.egress = 1e-3 * hour.mb * (is_ours ? prices.server_egress_gb : prices.cdn_egress_gb);
  if (is_ours) {
    hour.processor_s = 1e-3 * rate("compute_ms", "compute_in_flight_ms");
    hour.processor = hour.processor_s / 3600 / prices.processor_use * prices.processor_hour;
  } else {
    hour.requests = rate("requests", "requests_in_flight");
    hour.requests_cost = 1e-6 * hour.requests * prices.cdn_million_requests;
  }
  hour.cost = hour.egress + hour.requests_cost + hour.processor;
  return hour;
}

Status check(const Json& results) {
  const bool is_tiles = results.is_object() && results.value("experiment", "") == "tiles" &&
                        results.value("seconds", Json()).is_number() && results.value("ways", Json()).is_array();
  if (!is_tiles) return Error{ErrorCode::kMalformed, "these are no results of `foreland bench tiles SCENE --out DIR`"};
  for (const Json& row : results["ways"])
    for (const char* key : kNeeded)
      if (!row.is_object() || !row.value(key, Json()).is_number() || !row.value("way", Json()).is_string())
        return Error{ErrorCode::kMalformed,
                     std::string("a way has no '") + key + "'; run `foreland bench tiles` again, with this version"};
  if (results["ways"].empty() || results["ways"][0]["way"] != "foreland")
    return Error{ErrorCode::kMalformed, "the first way is not foreland's"};
  return {};
}

}  // namespace

Result<std::vector<ViewerHour>> viewerHours(const Json& results, const CostPrices& prices) {
  if (Status s = check(results); !s.ok()) return s.error();
  std::vector<ViewerHour> hours;
  for (const Json& row : results["ways"]) {
    hours.push_back(hourOf(row, results["seconds"], prices));
    if (hours[0].cost > 0) hours.back().over_foreland = hours.back().cost / hours[0].cost;
  }
  return hours;
}

}  // namespace foreland::lab
