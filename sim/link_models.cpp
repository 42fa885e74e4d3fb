#include "sim/link_models.h"

#include <array>

namespace foreland::sim {

namespace {

constexpr std::array<LinkModel, 5> kModels{{
    {.name = "fixed",
     .source = "no model: a constant latency and nothing else, for the grid of round trips",
     .round_trip_ms = 50,
     .jitter_ms = 0,
     .up_mbit_s = 0,
     .down_mbit_s = 0,
     .queue_kib = 0,
     .loss = 0,
     .stall_every_s = 0,
     .stall_ms = 0},
    {.name = "wifi",
     .source = "a home access point in front of a near server; Sommers and Barford, 'Cell vs. WiFi' (IMC 2012), for "
               "rates and latencies seen from WiFi, and Pei et al. (INFOCOM 2016) for the spread of the last hop",
     .round_trip_ms = 20,
     .jitter_ms = 20,
     .up_mbit_s = 10,
     .down_mbit_s = 40,
     .queue_kib = 64,
     .loss = 0.002,
     .stall_every_s = 0,
     .stall_ms = 0},
    {.name = "lte",
     .source = "Huang et al., 'A close examination of performance and power characteristics of 4G LTE networks' "
               "(MobiSys 2012): 13 Mbit/s down, 6 up, a round trip near 70 ms",
     .round_trip_ms = 70,
     .jitter_ms = 30,
     .up_mbit_s = 6,
     .down_mbit_s = 13,
     .queue_kib = 128,
     .loss = 0.002,
     .stall_every_s = 0,
     .stall_ms = 0},
    {.name = "starlink",
     .source =
         "Mohan et al., 'A multifaceted look at Starlink performance' (WWW 2024, arXiv 2310.09242), and Michel et "
         "al. (IMC 2022): 40 to 50 ms, about 1 % of the packets lost, an interruption each 15 s when satellites "
         "are assigned anew",
     .round_trip_ms = 45,
     .jitter_ms = 20,
     .up_mbit_s = 12,
     .down_mbit_s = 120,
     .queue_kib = 256,
     .loss = 0.01,
     .stall_every_s = 15,
     .stall_ms = 100},
    {.name = "geo",
     .source =
         "a geostationary satellite, twice 2 x 35,786 km at the speed of light (477 ms) and the terminals; the FCC's "
         "reports on fixed broadband ('Measuring Broadband America') have about 600 ms",
     .round_trip_ms = 600,
     .jitter_ms = 30,
     .up_mbit_s = 3,
     .down_mbit_s = 25,
     .queue_kib = 256,
     .loss = 0.005,
     .stall_every_s = 0,
     .stall_ms = 0},
}};

Duration half(double ms) { return Duration::seconds(0.5e-3 * ms); }

LinkOptions oneWay(const LinkModel& m, double mbit_s) {
  LinkOptions link;
  link.latency = half(m.round_trip_ms);
  link.jitter = half(m.jitter_ms);
  link.bytes_per_second = mbit_s * 1e6 / 8;
  link.queue_bytes = static_cast<size_t>(m.queue_kib * 1024);
  link.loss = m.loss;
  link.repeat_after = Duration::seconds(1e-3 * m.round_trip_ms);
  link.stall_every = Duration::seconds(m.stall_every_s);
  link.stall = Duration::seconds(1e-3 * m.stall_ms);
  return link;
}

}  // namespace

LinkPair LinkModel::links() const { return {oneWay(*this, up_mbit_s), oneWay(*this, down_mbit_s)}; }

std::span<const LinkModel> linkModels() { return kModels; }

Result<LinkModel> linkNamed(std::string_view name) {
  std::string all;
  for (const LinkModel& model : kModels) {
    if (name == model.name) return model;
    all += (all.empty() ? "" : ", ") + std::string(model.name);
  }
  return Error{ErrorCode::kInvalidArgument, "there is no link '" + std::string(name) + "'; choose one of " + all};
}

LinkPair fixedLink(Duration round_trip) {
  LinkModel model = kModels[0];
  model.round_trip_ms = round_trip.toMilliseconds();
  return model.links();
}

}  // namespace foreland::sim
