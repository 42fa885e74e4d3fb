#include "lab/load/cluster.h"
#include "base/quantile.h"

#include <algorithm>
#include <charconv>
#include <cmath>

namespace foreland::lab {

namespace {

Error invalid(const std::string& message) { return {ErrorCode::kInvalidArgument, message}; }

template <class Number>
bool reads(std::string_view text, Number& value) {
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  return error == std::errc() && end == text.data() + text.size();
}

}  // namespace

bool ClusterOptions::isThere(size_t server) const {
  const ServerEvent* first = nullptr;
  for (const ServerEvent& e : events)
    if (e.server == server && (!first || e.at_s < first->at_s)) first = &e;
  return !first || first->what != ServerEvent::What::kJoin;
}

Result<ServerEvent> parseServerEvent(ServerEvent::What what, const std::string& text) {
  ServerEvent event{.what = what};
  const size_t sign = text.find('@');
  const bool is_read = sign != std::string::npos && reads(std::string_view(text).substr(0, sign), event.server) &&
                       reads(std::string_view(text).substr(sign + 1), event.at_s) && std::isfinite(event.at_s) &&
                       event.server > 0;
  if (!is_read) return invalid("'" + text + "' is no SERVER@SECONDS, such as 2@5, with servers counted from 1");
  --event.server;
  return event;
}

Status checkCluster(const ClusterOptions& options, double seconds) {
  bool any = false;
  for (size_t i = 0; i < options.servers; ++i) any = any || options.isThere(i);
  for (const ServerEvent& e : options.events) {
    if (e.server >= options.servers)
      return invalid("there is no server " + std::to_string(e.server + 1) +
                     "; --servers says how many there are: " + std::to_string(options.servers));
    if (!(e.at_s >= 0 && e.at_s < seconds))
      return invalid("server " + std::to_string(e.server + 1) + " fails, drains or joins at " + std::to_string(e.at_s) +
                     " s, but 0 to " + std::to_string(seconds) + " s are measured");
  }
  if (!any) return invalid("all servers join later; at least one must be there at the beginning");
  return {};
}

void sumUp(const std::vector<ViewerMove>& moves, ClusterFigures& f) {
  std::vector<double> gaps, lost_gaps;
  for (const ViewerMove& m : moves) {
    f.moves += m.cause == MoveCause::kBalanced;
    f.migrated += m.cause == MoveCause::kDrained;
    f.lost += m.cause == MoveCause::kLost;
    f.afresh += !m.is_resumed;
    (m.cause == MoveCause::kLost ? lost_gaps : gaps).push_back(m.gap_ms);
    const double n = static_cast<double>(moves.size()), up = static_cast<double>(m.up),
                 down = static_cast<double>(m.down);
    f.move_up_mean += up / n, f.move_up_max = std::max(f.move_up_max, up);
    f.move_down_mean += down / n, f.move_down_max = std::max(f.move_down_max, down);
  }
  f.move_gap_p50_ms = quantile(gaps, 0.5), f.move_gap_max_ms = quantile(gaps, 1);
  f.lost_gap_p50_ms = quantile(lost_gaps, 0.5), f.lost_gap_p99_ms = quantile(lost_gaps, 0.99);
  f.lost_gap_max_ms = quantile(lost_gaps, 1);
}

}  // namespace foreland::lab
