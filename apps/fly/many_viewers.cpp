#include "apps/fly/many_viewers.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <optional>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "apps/fly/flight.h"
#include "apps/fly/link.h"
#include "apps/report.h"

namespace foreland::apps {
namespace {

using Clock = Link::Clock;
constexpr std::chrono::milliseconds kManyFrame{50};
constexpr std::chrono::milliseconds kBetweenStarts{20};  // so that not all ask for their tours in one instant

struct Flown {
  Status status;
  client::FlightReport report;
};

Flown flyOne(const FlyOptions& o, const client::PlayerOptions& options, size_t number) {
  std::this_thread::sleep_for(kBetweenStarts * number);
  auto connection = client::WebSocketClient::connect(o.url, kConnectTimeout, o.connection);
  if (!connection.ok()) return {connection.error(), {}};
  client::Player player(options);
  Link link(std::move(connection).value(), o.url, o.connection, static_cast<uint32_t>(number + 1));
  Status status = fly(link, player, kManyFrame, {});
  link.close();
  return {std::move(status), player.report()};
}

// The value that the share `part` of `ascending` does not exceed.
double percentile(const std::vector<double>& ascending, double part) {
  if (ascending.empty()) return 0;
  return ascending[static_cast<size_t>(std::lround(part * static_cast<double>(ascending.size() - 1)))];
}

void addGaps(const std::vector<Flown>& all, nlohmann::ordered_json& json) {
  std::vector<double> gaps_ms;
  for (const Flown& one : all) gaps_ms.push_back(one.report.longest_gap.toMilliseconds());
  std::sort(gaps_ms.begin(), gaps_ms.end());
  json["longest_gap_p50_ms"] = percentile(gaps_ms, 0.5);
  json["longest_gap_p99_ms"] = percentile(gaps_ms, 0.99);
  json["longest_gap_ms"] = percentile(gaps_ms, 1);
}

nlohmann::ordered_json reportOf(const std::vector<Flown>& all) {
  uint64_t landed = 0, keyframes = 0, late = 0, down = 0, up = 0, resumed = 0, afresh = 0;
  Duration longest_resume;
  std::optional<std::string> error;
  for (const Flown& one : all) {
    const client::ViewerStatistics& s = one.report.session;
    landed += one.status.ok();
    if (!one.status.ok() && !error) error = one.status.error().message;
    keyframes += one.report.keyframes_flying;
    late += one.report.late_keyframes_flying;
    down += s.bytes_down;
    up += s.bytes_up;
    resumed += s.resumed;
    afresh += s.started_afresh;
    longest_resume = std::max(longest_resume, s.longest_resume);
  }
  nlohmann::ordered_json json = {
      {"viewers", all.size()},  {"landed", landed},         {"keyframes", keyframes},
      {"late_keyframes", late}, {"bytes_down", down},       {"bytes_up", up},
      {"resumed", resumed},     {"started_afresh", afresh}, {"longest_resume_ms", longest_resume.toMilliseconds()}};
  addGaps(all, json);
  if (error) json["error"] = *error;
  return json;
}

}  // namespace

// Their meshes would take the processor's time from the server whose limits are looked for, and nobody sees them.
int flyMany(const FlyOptions& o, client::PlayerOptions options) {
  options.has_meshes = false;
  std::vector<Flown> all(o.viewers);
  {
    std::vector<std::jthread> threads;
    for (size_t i = 0; i < all.size(); ++i) threads.emplace_back([&, i] { all[i] = flyOne(o, options, i); });
  }
  std::fputs(apps::text(reportOf(all), o.format).c_str(), stdout);
  const auto failed = std::count_if(all.begin(), all.end(), [](const Flown& one) { return !one.status.ok(); });
  if (failed > 0) std::fprintf(stderr, "foreland fly: %td of %zu viewers did not fly to the end\n", failed, all.size());
  return failed == 0 ? 0 : 2;
}

}  // namespace foreland::apps
