#include "lab/external/told_link.h"

#include <map>

namespace foreland::lab {

namespace {

class ProgramCarrier final : public sim::Carrier {
 public:
  ProgramCarrier(AskedProgram& program, const char* way) : program_(program), way_(way) {}

  Carried carry(uint64_t link_seed, size_t bytes, Time now) override {
    const uint64_t link = links_.try_emplace(link_seed, links_.size()).first->second;
    const auto answer =
        program_.ask({{"ask", "carry"}, {"way", way_}, {"link", link}, {"bytes", bytes}, {"time_us", now.us}});
    if (!answer) return {now, now};
    constexpr int64_t kLongest_us = 3'600'000'000;
    const auto leaves = program_.whole(*answer, "leaves_us", now.us, now.us + kLongest_us);
    if (!leaves) return {now, now};
    const auto arrives = program_.whole(*answer, "arrives_us", *leaves, now.us + kLongest_us);
    if (!arrives) return {now, now};
    return {{*leaves}, {*arrives}};
  }

 private:
  AskedProgram& program_;
  const char* way_;
  std::map<uint64_t, uint64_t> links_;  // by their seeds: in the order of their first messages
};

}  // namespace

sim::LinkPair toldLinks(AskedProgram& program) {
  sim::LinkPair links = sim::fixedLink(Duration::milliseconds(50));
  links.up.carrier = std::make_shared<ProgramCarrier>(program, "up");
  links.down.carrier = std::make_shared<ProgramCarrier>(program, "down");
  return links;
}

}  // namespace foreland::lab
