#include "server/net/fleet_level.h"

#include <algorithm>
#include <charconv>

#include "base/smoothing.h"
#include "server/net/metrics/load.h"

namespace foreland::server {
namespace {

std::optional<uint64_t> numberIn(std::string_view text) {
  uint64_t number = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
  if (error != std::errc() || end != text.data() + text.size()) return std::nullopt;
  return number;
}

// Of "UP; ...; weight=30/120; scur=3/9; qcur=0" the 120.
std::optional<uint64_t> weightOfAll(std::string_view state) {
  constexpr std::string_view kName = "; weight=";
  const size_t at = state.find(kName);
  if (at == std::string_view::npos) return std::nullopt;
  std::string_view weights = state.substr(at + kName.size());
  weights = weights.substr(0, weights.find(';'));
  const size_t slash = weights.find('/');
  return slash == std::string_view::npos ? std::nullopt : numberIn(weights.substr(slash + 1));
}

}  // namespace

void FleetLevel::note(std::string_view state, std::string_view servers, Time now) {
  const auto weight = weightOfAll(state), ready = numberIn(servers);
  if (!weight || !ready || *ready > kMaxServers || *weight > 100 * *ready) return;
  const double free = *ready == 0 ? 0 : static_cast<double>(*weight) / (100 * static_cast<double>(*ready));
  const double level = *ready == 0 ? 1 : Load::kBusy * (1 - free);
  const bool is_known = at(now).has_value();
  const double elapsed_s = is_known ? (now - *noted_at_).toSeconds() : 0;
  level_ = is_known ? level_ + weightOfNew(elapsed_s, kMemory.toSeconds()) * (level - level_) : level;
  noted_at_ = now;
}

std::optional<double> FleetLevel::at(Time now) const {
  return noted_at_ && now <= *noted_at_ + kLasting ? std::optional(level_) : std::nullopt;
}

}  // namespace foreland::server
