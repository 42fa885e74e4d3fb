// Links that experiments name. The figures are typical ones, rounded, with their sources in link_models.cpp; whoever
// has a recording of the link at hand uses that (link_trace.h). Immutable; any thread.
#pragma once

#include <span>
#include <string>
#include <string_view>

#include "base/result.h"
#include "sim/link.h"

namespace foreland::sim {

struct LinkPair {
  LinkOptions up, down;
};

struct LinkModel {
  const char* name;
  const char* source;               // for people: where the figures are from
  double round_trip_ms, jitter_ms;  // half of both each way
  double up_mbit_s, down_mbit_s;    // 0: no limit
  double queue_kib, loss;
  double stall_every_s, stall_ms;  // 0: none

  LinkPair links() const;
};

std::span<const LinkModel> linkModels();
// The Error lists the names.
Result<LinkModel> linkNamed(std::string_view name);
// The model `fixed` with another round trip.
LinkPair fixedLink(Duration round_trip);

}  // namespace foreland::sim
