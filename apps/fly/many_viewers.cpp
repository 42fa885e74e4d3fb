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
#include "apps/report/report.h"
#include "apps/report/summary.h"

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

// Of all viewers together.
struct Fleet {
  uint64_t viewers = 0, landed = 0, keyframes = 0, late = 0, bytes_down = 0, bytes_up = 0, resumed = 0, afresh = 0;
  Duration longest_resume;
  double viewer_seconds = 0;         // flown
  std::vector<double> gaps_ms;       // the longest of each viewer, ascending
  std::optional<std::string> error;  // the first
};

Fleet together(const std::vector<Flown>& all) {
  Fleet fleet;
  fleet.viewers = all.size();
  for (const Flown& one : all) {
    const client::ViewerStatistics& s = one.report.session;
    fleet.landed += one.status.ok();
    if (!one.status.ok() && !fleet.error) fleet.error = one.status.error().message;
    fleet.keyframes += one.report.keyframes_flying;
    fleet.late += one.report.late_keyframes_flying;
    fleet.bytes_down += s.bytes_down;
    fleet.bytes_up += s.bytes_up;
    fleet.resumed += s.resumed;
    fleet.afresh += s.started_afresh;
    fleet.longest_resume = std::max(fleet.longest_resume, s.longest_resume);
    fleet.viewer_seconds += one.report.seconds;
    fleet.gaps_ms.push_back(one.report.longest_gap.toMilliseconds());
  }
  std::sort(fleet.gaps_ms.begin(), fleet.gaps_ms.end());
  return fleet;
}

nlohmann::ordered_json reportOf(const Fleet& f) {
  nlohmann::ordered_json json = {{"viewers", f.viewers},
                                 {"landed", f.landed},
                                 {"keyframes", f.keyframes},
                                 {"late_keyframes", f.late},
                                 {"bytes_down", f.bytes_down},
                                 {"bytes_up", f.bytes_up},
                                 {"resumed", f.resumed},
                                 {"started_afresh", f.afresh},
                                 {"longest_resume_ms", f.longest_resume.toMilliseconds()}};
  json["longest_gaps_ms"] = f.gaps_ms;
  json["longest_gap_p50_ms"] = percentile(f.gaps_ms, 0.5);
  json["longest_gap_p99_ms"] = percentile(f.gaps_ms, 0.99);
  json["longest_gap_ms"] = percentile(f.gaps_ms, 1);
  if (f.error) json["error"] = *f.error;
  return json;
}

Summary summaryFor(const Fleet& f, std::optional<double> asked_s) {
  Summary out;
  const double viewers = static_cast<double>(f.viewers), down = static_cast<double>(f.bytes_down),
               seconds = std::max(f.viewer_seconds, 1e-3);
  out.add("viewers", count(f.landed) + " of " + count(f.viewers) + " flew to the end; " +
                         digits(f.viewer_seconds / viewers) + " s each on average" +
                         (asked_s ? " (asked: " + shortest(*asked_s) + " s)" : ""));
  out.add("keyframes", count(f.keyframes) + ", " + count(f.late) + " late");
  out.add("gaps", "the longest between two keyframes of a viewer: " + millisecondsText(percentile(f.gaps_ms, 0.5)) +
                      " in the median, " + millisecondsText(percentile(f.gaps_ms, 0.99)) + " at the 99th percentile, " +
                      millisecondsText(percentile(f.gaps_ms, 1)) + " at most");
  out.add("received", bytesText(down) + ", " + bytesText(down / seconds) + "/s each; sent " +
                          bytesText(static_cast<double>(f.bytes_up)));
  if (f.resumed + f.afresh > 0)
    out.add("connections", "lost and made again: " + count(f.resumed) + " resumed, " + count(f.afresh) +
                               " from nothing, within " + millisecondsText(f.longest_resume.toMilliseconds()));
  if (f.late > 0)
    out.addProblem(count(f.late) + " of " + count(f.keyframes, "keyframe") + " came late",
                   "these are more viewers than the server, the link or this machine can carry");
  if (f.landed < f.viewers)
    out.addProblem(count(f.viewers - f.landed) + " of " + count(f.viewers, "viewer") + " did not fly to the end",
                   "the first: " + f.error.value_or(""));
  return out;
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
  const Fleet fleet = together(all);
  const std::optional<double> asked_s = options.track ? options.track_options.seconds : options.seconds;
  std::fputs(o.format == ReportFormat::kJson ? text(reportOf(fleet), o.format).c_str()
                                             : summaryFor(fleet, asked_s).text(paintFor(stdout)).c_str(),
             stdout);
  const auto failed = std::count_if(all.begin(), all.end(), [](const Flown& one) { return !one.status.ok(); });
  if (failed > 0) std::fprintf(stderr, "foreland fly: %td of %zu viewers did not fly to the end\n", failed, all.size());
  return failed == 0 ? 0 : 2;
}

}  // namespace foreland::apps
