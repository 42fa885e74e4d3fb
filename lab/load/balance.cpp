#include "lab/load/balance.h"

#include <algorithm>
#include <array>

#include "lab/load/named.h"

namespace foreland::lab {

namespace {

constexpr std::array<const char*, 5> kBalances{"random", "round-robin", "least-loaded", "two-choices", "migrate"};

size_t leastUsed(std::span<const ServerLoad> servers, std::span<const size_t> among) {
  return *std::min_element(among.begin(), among.end(),
                           [&](size_t a, size_t b) { return servers[a].used < servers[b].used; });
}

std::vector<size_t> openOnes(std::span<const ServerLoad> servers) {
  std::vector<size_t> open;
  for (size_t i = 0; i < servers.size(); ++i)
    if (servers[i].is_open) open.push_back(i);
  return open;
}

class OwnBalancer final : public Balancer {
 public:
  OwnBalancer(Balance balance, Rng& chance) : balance_(balance), chance_(chance) {}
  std::optional<size_t> place(std::span<const ServerLoad> servers, const Arrival& arrival) override {
    return placeViewer(balance_, servers, arrival.turn, chance_);
  }
  bool queuesResumed() const override { return balance_ == Balance::kMigrate; }
  std::optional<Move> move(std::span<const ServerLoad> servers, std::span<const ViewerLoad> viewers, Time) override {
    return balance_ == Balance::kMigrate ? moveToMake(servers, viewers) : std::nullopt;
  }

 private:
  Balance balance_;
  Rng& chance_;
};

}  // namespace

std::unique_ptr<Balancer> makeBalancer(Balance balance, Rng& chance) {
  return std::make_unique<OwnBalancer>(balance, chance);
}

const char* name(Balance balance) { return kBalances[static_cast<size_t>(balance)]; }
Result<Balance> balanceNamed(const std::string& name) { return named<Balance>(name, "balance", kBalances); }
std::vector<std::string> balanceNames() { return {kBalances.begin(), kBalances.end()}; }

std::optional<size_t> placeViewer(Balance balance, std::span<const ServerLoad> servers, size_t turn, Rng& chance) {
  std::vector<size_t> open = openOnes(servers);
  if (balance == Balance::kMigrate) std::erase_if(open, [&](size_t s) { return servers[s].is_pausing; });
  if (open.empty()) return std::nullopt;
  if (balance == Balance::kRandom) return open[chance.below(open.size())];
  if (balance == Balance::kRoundRobin) return open[turn % open.size()];
  if (balance != Balance::kTwoChoices || open.size() < 2) return leastUsed(servers, open);
  const size_t first = chance.below(open.size()), step = 1 + chance.below(open.size() - 1);
  return leastUsed(servers, std::array{open[first], open[(first + step) % open.size()]});
}

std::optional<Move> moveToMake(std::span<const ServerLoad> servers, std::span<const ViewerLoad> viewers) {
  const std::vector<size_t> open = openOnes(servers);
  if (open.size() < 2) return std::nullopt;
  const size_t to = leastUsed(servers, open);
  const size_t from = *std::max_element(open.begin(), open.end(),
                                        [&](size_t a, size_t b) { return servers[a].used < servers[b].used; });
  const double difference = servers[from].used - servers[to].used;
  if (servers[from].used < kBusy || difference < kUneven || servers[to].is_pausing) return std::nullopt;
  std::optional<Move> best;
  for (size_t i = 0; i < viewers.size(); ++i) {
    const ViewerLoad& v = viewers[i];
    if (v.server != from || !v.is_movable || v.used <= 0 || v.used > difference / 2 || v.resume_s > kLongestResume_s)
      continue;
    if (!best || v.used > viewers[best->viewer].used) best = Move{i, to};
  }
  return best;
}

}  // namespace foreland::lab
