// What a viewer-hour costs by our stream and by tiles from a CDN: the bytes, requests and processor time of the flights
// of `foreland bench tiles`, at prices that the user gives. Pure; any thread.
#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "base/result.h"

namespace foreland::lab {

// In one currency.
struct CostPrices {
  std::string name{}, currency{};
  double visit_minutes = 0;     // that a viewer stays; it pays for its first view once a visit
  double server_egress_gb = 0;  // of 10^9 bytes that leave a server of ours
  double processor_hour = 0;    // of one processor of that server
  double processor_use = 1;     // share of a processor's time that is used in the mean; the rest is paid, too
  double cdn_egress_gb = 0, cdn_million_requests = 0;
};

struct ViewerHour {
  std::string way;  // foreland, quantized-mesh, draco
  double asked_px = 0, rms_px = 0;
  double mb = 0, requests = 0, processor_s = 0;  // an hour; processor time and requests only where they are paid
  double egress = 0, requests_cost = 0, processor = 0, cost = 0;
  double over_foreland = 0;  // the cost, over that of our stream

  template <class Visit>
  void fields(const Visit& visit) const {
    visit("way", way);
    visit("asked_px", asked_px);
    visit("rms_px", rms_px);
    visit("mb_per_hour", mb);
    visit("requests_per_hour", requests);
    visit("processor_s_per_hour", processor_s);
    visit("egress_cost", egress);
    visit("requests_cost", requests_cost);
    visit("processor_cost", processor);
    visit("cost", cost);
    visit("cost_over_foreland", over_foreland);
  }
};

// Of each way in the results.json of `foreland bench tiles`, ours first. An Error if it is of another experiment or of
// an older version.
Result<std::vector<ViewerHour>> viewerHours(const nlohmann::ordered_json& results, const CostPrices& prices);

}  // namespace foreland::lab
